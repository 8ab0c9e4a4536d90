import marimo

__generated_with = "0.25.2"
app = marimo.App(width="medium", app_title="Differences", html_head_file="head.html")


@app.cell(hide_code=True)
def _():
    import marimo as mo

    from gnsslab.teaching.marimo_front import open_lesson

    lesson = open_lesson("02")
    return lesson, mo


@app.cell(hide_code=True)
def _(lesson):
    lesson.head()
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## The scene

    Two receivers stand on tripods, **1 km** apart. You want to know the line from one to the other, the *master*, to the *rover*,
    to a centimetre.

    Look at what they measure. The rover's clock is wrong by 10 microseconds: light travels **3 km** in that time. Each satellite's clock
    is wrong by up to half a millisecond: **150 km**. Above you, the air delays every signal by **2 to 30 m**, and nobody knows by how much.

    You will get your centimetre all the same. The tool is subtraction.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## Predict

    Commit to an answer before you see anything. The labs open once you have chosen.
    """)
    return


@app.cell(hide_code=True)
def _(lesson):
    prediction = lesson.prediction()
    prediction
    return (prediction,)


@app.cell(hide_code=True)
def _(lesson, prediction):
    lesson.predicted(prediction)
    return


@app.cell(hide_code=True)
def _(lesson, prediction):
    lesson.text(prediction, r"""
    ## Play

    The picture shows one pair of satellites. Every dot is *measured minus geometric*: what a receiver read, less the true distance to the
    satellite. What is left is error. Each line of the axis is **a hundred times** the one below.

    Blue circles: one receiver, one satellite. Two receivers and two satellites make four lines, and some lie on each other. Orange triangles:
    rover minus master, for each satellite. Squares: that, one satellite minus the other. The second picture shows the noise alone, on one scale.
    """)
    return


@app.cell(hide_code=True)
def _(lesson, mo):
    cancelling = lesson.lab("cancelling")
    chosen, choose = mo.state(None)
    return cancelling, choose, chosen


@app.cell(hide_code=True)
def _(cancelling, choose, lesson, prediction):
    lesson.wait(prediction)
    presets = cancelling.presets(choose)
    cancelling.preset_row(presets)
    return (presets,)


@app.cell(hide_code=True)
def _(cancelling, controls, steering):
    result = cancelling.run(steering.value, controls.value)
    cancelling.view(result)
    return (result,)


@app.cell(hide_code=True)
def _(cancelling, chosen, lesson, prediction):
    lesson.wait(prediction)
    steering = cancelling.steering(chosen())
    return (steering,)


@app.cell(hide_code=True)
def _(cancelling, chosen, steering):
    controls = cancelling.controls(steering.value, chosen())
    cancelling.panel(steering, controls)
    return (controls,)


@app.cell(hide_code=True)
def _(cancelling, lesson, prediction):
    lesson.wait(prediction)
    saving = cancelling.saving()
    cancelling.saving_row(saving)
    return (saving,)


@app.cell(hide_code=True)
def _(cancelling, saving):
    cancelling.link(saving.value)
    return


@app.cell(hide_code=True)
def _(lesson, prediction):
    lesson.text(prediction, r"""
    **What you see.** Two subtractions take the error from 100 km down to millimetres. The first one removes what the *satellite* did: its clock.
    What is left is the same for both satellites: their triangles lie on each other. So the second one removes it. It is what the *receivers*
    did: their clocks. The squares lie far below the dashed line, which is one wave of the carrier. So you can tell which whole wave you are on.

    Try these, one at a time:

    1. Move **Rover's clock error** to 1 ms. The triangles jump to 300 km. The squares stay.
    2. Move **Baseline length** to 0, then to 10 km. At 10 km the squares are at 3 cm, because the air above the two
       receivers is not the same any more.
    3. Set **Atmosphere** to *none* at 10 km. The squares fall again. Then try each part alone.
    4. Set **Clocks** to *all perfect* and **Atmosphere** to *none*. Now all three levels are millimetres. The second picture says what
       subtraction costs: 1.4 times the noise, then twice the noise.
    5. Press **A millisecond, believed**. The squares rise to a quarter of a metre. A clock error does no harm in the measurement, but
       it does in your *computation* of where the satellites were.

    **And your answer?** Millimetres. Four numbers, each wrong by kilometres, combine into one that is right to millimetres. What made them wrong
    was the same in two of them, each time.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## Why it works

    ### What cancels

    Call the receiver [$r$](/notation#r) and the satellite [$s$](/notation#s). The code [$P$](/notation#P) and the carrier phase
    [$\Phi$](/notation#Phi), both in metres, are those of lesson 01:

    $$P_r^s = \rho_r^s + c\,(dt_r - dt^s) + T_r^s + I_r^s + \varepsilon_P$$

    $$\Phi_r^s = \rho_r^s + c\,(dt_r - dt^s) + T_r^s - I_r^s + \lambda N_r^s + \varepsilon_\Phi$$

    Here $\rho$ is the distance, $c$ the speed of light, [$dt_r$](/notation#dt_r) and [$dt^s$](/notation#dt_s) the errors of the two clocks,
    $T$ and $I$ the delays of troposphere and ionosphere, $\lambda$ the wavelength, $N$ a whole number of waves that nobody knows, and
    $\varepsilon$ noise.

    In words: a measurement is the distance, plus the receiver's clock error, less the satellite's, plus the air. The ionosphere holds the code back
    and hurries the carrier on by as much. The carrier is read to millimetres, but its count of waves starts anywhere.

    The *single difference* [$\Delta$](/notation#Delta) is rover minus master, for one satellite:

    $$\begin{aligned}\Delta\Phi^s = {} & \Delta\rho^s + c\,\Delta dt + \Delta T^s - \Delta I^s \\ & + \lambda\,\Delta N^s + \Delta\varepsilon_\Phi\end{aligned}$$

    In words: $dt^s$ is the same number in both receivers' measurements, so it is gone. The receivers' clocks remain, as one number $\Delta dt$, the
    same for every satellite.

    The *double difference* [$\nabla\Delta$](/notation#nabla_Delta) is satellite $s$ minus a *reference satellite*, number 1:

    $$\begin{aligned}\nabla\Delta\Phi^{s1} = {} & \nabla\Delta\rho^{s1} + \nabla\Delta T^{s1} - \nabla\Delta I^{s1} \\ & + \lambda\,\nabla\Delta N^{s1} + \nabla\Delta\varepsilon_\Phi\end{aligned}$$

    In words: $\Delta dt$ is the same for both satellites, so it is gone too. What remains is geometry, which you want; a whole number of waves;
    a little air; and noise.

    **How little air?** The two signals of one satellite pass through the same air but for the distance between the receivers. Up to 3 mm are left
    for each kilometre, most for low satellites. That is why this works over kilometres and not over continents.

    **And the clock after all.** The satellite moves. Its distance changes by up to 800 m in a second, so by 0.8 m in a millisecond. Ask where it
    was *at the time on the tag*, and you are wrong by up to that. Ask where it was when the signal left, at tag minus $P/c$. The tag
    and the code hold the same clock error, so it cancels even there.

    All symbols stand on the [notation page](/notation).
    """)
    return


@app.cell(hide_code=True)
def _(lesson, prediction):
    lesson.text(prediction, r"""
    ### What grows

    Noise does not cancel. Four readings are in a double difference, and each brings its own error. Worse: all double differences contain
    the *same* two readings of the reference satellite. If those are off, all of them are off together.

    The matrices show this. Left: 1000 epochs of drawn noise, differenced twice, and the covariance that comes out by itself. Right: the covariance
    that the solver works with. The unit is the variance of one reading.

    Below them you see what comes of it. At each epoch the solver looks for the whole numbers that fit best, and for those that fit second best.
    The **ratio** says how much farther away the second best are. A large one is good; from the dashed line on, the best are believed. With fewer
    satellites the line stands farther right. **Right integers** counts all epochs, believed or not. Beside it stands the share that the solver's own
    covariance *promises*. The cloud shows what the baselines are with the right integers, in height and to the east.
    """)
    return


@app.cell(hide_code=True)
def _(lesson, mo):
    correlation = lesson.lab("correlation")
    chosen_pattern, choose_pattern = mo.state(None)
    return choose_pattern, chosen_pattern, correlation


@app.cell(hide_code=True)
def _(choose_pattern, correlation, lesson, prediction):
    lesson.wait(prediction)
    presets_pattern = correlation.presets(choose_pattern)
    correlation.preset_row(presets_pattern)
    return (presets_pattern,)


@app.cell(hide_code=True)
def _(controls_pattern, correlation, steering_pattern):
    result_pattern = correlation.run(steering_pattern.value, controls_pattern.value)
    correlation.view(result_pattern)
    return (result_pattern,)


@app.cell(hide_code=True)
def _(chosen_pattern, correlation, lesson, prediction):
    lesson.wait(prediction)
    steering_pattern = correlation.steering(chosen_pattern())
    return (steering_pattern,)


@app.cell(hide_code=True)
def _(chosen_pattern, correlation, steering_pattern):
    controls_pattern = correlation.controls(steering_pattern.value, chosen_pattern())
    correlation.panel(steering_pattern, controls_pattern)
    return (controls_pattern,)


@app.cell(hide_code=True)
def _(correlation, lesson, prediction):
    lesson.wait(prediction)
    saving_pattern = correlation.saving()
    correlation.saving_row(saving_pattern)
    return (saving_pattern,)


@app.cell(hide_code=True)
def _(correlation, saving_pattern):
    correlation.link(saving_pattern.value)
    return


@app.cell(hide_code=True)
def _(lesson, prediction):
    lesson.text(prediction, r"""
    **What you see.** 4 on the diagonal: four readings. 2 beside it: two of the four are shared. You did not put that in. It came out of the noise.

    Press **Ignored**. The measurements are the same ones, and only the solver's opinion changed. The ratios fall, so fewer epochs
    can be believed. The black ellipse turns away from the dots: the solver is too sure of the height and not sure enough of east and north.

    Press **Low reference**. The low satellites are noisier now, so there are fewer right integers than at the start. Choose another
    **Reference satellite**: not a single ratio moves. Then press **Low reference, ignored**. A poor reference does no harm to a solver that knows. It
    ruins one that does not.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ### The 4-2-2 pattern

    Write the single differences of $m$ satellites as one vector. The *difference operator* [$D$](/notation#D) takes the reference away from each of
    the others. (In lesson 01 the same letter was the Doppler.) It has $m - 1$ rows and $m$ columns. For four satellites:

    $$D = \begin{bmatrix} -1 & 1 & 0 & 0 \\ -1 & 0 & 1 & 0 \\ -1 & 0 & 0 & 1 \end{bmatrix}$$

    Each row sums to zero: whatever is the same for all satellites cancels. Let one reading of satellite $i$ have the standard deviation
    [$\sigma_i$](/notation#sigma_i). A single difference of two receivers has the variance $2\sigma_i^2$, and the double differences have the
    covariance matrix [$Q_y$](/notation#Q_y):

    $$Q_y = D\,\operatorname{diag}(2\sigma_1^2,\ \dots,\ 2\sigma_m^2)\,D^{\mathsf T}$$

    With equal $\sigma$:

    $$Q_y = \sigma^2 \begin{bmatrix} 4 & 2 & 2 \\ 2 & 4 & 2 \\ 2 & 2 & 4 \end{bmatrix}$$

    In words: variances of independent readings add, whatever the sign. So a double difference has four times the variance of one reading, and
    twice its standard deviation. Two double differences share the reference's two readings, so half of their variance is common.

    The measurements [$y$](/notation#y), double differences of carrier and code, follow the *mixed model*. It is called so because some of its
    unknowns are whole numbers and some are not:

    $$y = A\,a + B\,b + e, \qquad e \sim N(0,\ Q_y)$$

    Here [$a$](/notation#a) are the whole numbers and $b$ is the baseline. [$A$](/notation#A) holds the wavelength for a carrier and zero for a
    code. [$B$](/notation#B) is $-D\,u$, where the rows of $u$ point to the satellites. The errors $e$ scatter about zero with the covariance $Q_y$.
    Least squares weighs with its inverse:

    $$\hat b = (B^{\mathsf T} Q_y^{-1} B)^{-1} B^{\mathsf T} Q_y^{-1}\,(y - A\,a)$$

    In words: believe each measurement as far as it is good, and count what two of them have in common only once.

    **Another reference?** It is only another set of sums of the same differences, $y' = T y$ with an invertible matrix $T$ (not the
    troposphere). Then $Q_{y'} = T Q_y T^{\mathsf T}$, and $T$ drops out of $\hat b$. Throw the correlation away, and it does not drop out: the baseline then depends on which satellite you happened to subtract.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## The same in ten lines

    Copy this. It reads two observation files and forms both differences of the codes.

    ```python
    import gnsslab as gl
    from gnsslab.gnss.correlation import double_difference_covariance
    from gnsslab.gnss.differences import difference_operator, pair_receivers

    master, rover = gl.read_rinex_obs("master.obs"), gl.read_rinex_obs("rover.obs")
    pair = pair_receivers(master, rover, systems="G", frequencies=1)
    single = pair.rover.code - pair.master.code  # (T, m) the satellites' clocks are gone
    D = difference_operator(single.shape[1], reference=0)
    double = single @ D.T  # (T, m - 1) the receivers' clocks are gone
    print(single[0].round(1), double[0].round(1))
    print(double_difference_covariance([1.0] * single.shape[1], reference=0))
    ```

    No files at hand? `gnsslab simulate static-baseline -o roof` writes some, of two antennas 1.167 m apart. There the first line printed says
    kilometres, the same for each satellite; the second says a metre or two. The matrix below them is
    the 4-2-2 pattern.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## Reach a goal

    The first goal belongs to the first lab, the second to the second. They are judged as you move. Not
    all controls that help are in sight: look under *more*.
    """)
    return


@app.cell(hide_code=True)
def _(cancelling, result):
    cancelling.goal("calm", result)
    return


@app.cell(hide_code=True)
def _(correlation, result_pattern):
    correlation.goal("frugal", result_pattern)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## Real data

    Set **Data** to *real pair* in either lab. Two stations of Japan's network GEONET, 3335.39 m apart, on 2 April 2005, for an hour. Nobody
    simulated this.

    In the first lab:

    * The receivers' clocks run apart by **750 m each second**. After an hour the single difference is 2600 km off. The double difference does
      not care: it stays within two centimetres of a whole number of waves.
    * That whole number is 61 649 713. Each receiver starts its count anywhere, so it may be any number. It stays the same for the whole hour.
    * At the two upper levels the clocks hide the noise completely. Only the double difference shows it.

    In the second lab, press **Real stations**, then **Real, ignored**:

    * The pattern is there: 2 to 3 beside the diagonal, where 4 is the mean of the diagonal. It is not clean. Satellites differ,
      and reflected signals last for minutes.
    * Ignoring it costs integers here as well, and the baseline then depends on the reference.
    * The solver promises far too little success, because the sigmas that our engine assumes are about twice those of these good receivers. Whoever
      believes such promises must believe the sigmas first.

    Set **Data** to *my files* to use your own: two receivers that stand still, and broadcast orbits.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## Find the printed error

    Three papers write down what this lesson does. Each has a slip. Find the first two in the second lab: choose **The solver believes**.

    **Paper of 2019, equations (10) to (13).** Printed: $R = \operatorname{diag}(\delta^1, \dots, \delta^{m-1})$ and $D R D^{\mathsf T}$, where $\delta$ is the *error* of a
    measurement. Two things are wrong. $D$ has $m$ columns and $R$ has $m - 1$, so the product does not exist. And the entries
    must be variances: sigmas, squared. Corrected: $\operatorname{diag}(2\sigma_1^2, \dots, 2\sigma_m^2)$.

    **Second paper of 1998, equation (7).** Printed: the noise of rover minus master is $2V$. Corrected: $V_m - V_j$, the noise of two receivers $m$ and $j$.
    $2V$ has the variance $4\sigma^2$; the difference of two independent receivers has $2\sigma^2$.

    The same 1000 epochs, at the start of the second lab:

    | the solver believes | right integers | promised | median ratio | height, claimed | height, real |
    |---|---|---|---|---|---|
    | correlation respected | 97.7 % | 94.4 % | 3.63 | 6.3 mm | 6.4 mm |
    | correlation ignored | 87.5 % | 81.4 % | 2.59 | 5.4 mm | 8.5 mm |
    | as printed: not squared | 24.1 % | 0.2 % | 1.28 | 81.5 mm | 6.4 mm |
    | as printed: 2 V | 97.7 % | 65.2 % | 3.63 | 8.9 mm | 6.4 mm |

    Not squared, the numbers depend on the unit: in metres a sigma of 0.003 stands for a variance of 0.000009, and all carriers look
    13 times worse than they are. The codes look only 1.3 times worse, so the carriers lose their advantage over them. With $2V$ the ratios do not move at all, because a common
    factor cancels in them. Only the promises and the sigmas are wrong, and nobody looks at those.

    **Paper of 2021, equation (1).** Printed: $\lambda\phi = R - cV_{t_j} + cV_{t^p} - \lambda N - V_{ion} - V_{trop}$. The text calls the $V$ errors and delays. Then
    every sign but the ionosphere's is the wrong way round: a receiver's clock that is fast makes the measured range longer, and so does the troposphere. It
    can be saved by reading each $V$ as a correction and counting $N$ backwards. Why did nobody notice? The double difference cancels the clocks, whatever
    their sign.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## Check yourself

    Type a number. A comma or a point, with the unit or without: both are read. There are two hints for each question.
    """)
    return


@app.cell(hide_code=True)
def _(lesson):
    four_readings = lesson.ask("sigma-of-a-double-difference")
    lesson.sheet("sigma-of-a-double-difference", four_readings)
    return (four_readings,)


@app.cell(hide_code=True)
def _(four_readings, lesson):
    lesson.check("sigma-of-a-double-difference", four_readings.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    shared = lesson.ask("correlation-of-two-differences")
    lesson.sheet("correlation-of-two-differences", shared)
    return (shared,)


@app.cell(hide_code=True)
def _(lesson, shared):
    lesson.check("correlation-of-two-differences", shared.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    poor = lesson.ask("correlation-with-a-poor-reference")
    lesson.sheet("correlation-with-a-poor-reference", poor)
    return (poor,)


@app.cell(hide_code=True)
def _(lesson, poor):
    lesson.check("correlation-with-a-poor-reference", poor.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    millisecond = lesson.ask("millisecond-of-the-rover")
    lesson.sheet("millisecond-of-the-rover", millisecond)
    return (millisecond,)


@app.cell(hide_code=True)
def _(lesson, millisecond):
    lesson.check("millisecond-of-the-rover", millisecond.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    counted = lesson.ask("how-many-double-differences")
    lesson.sheet("how-many-double-differences", counted)
    return (counted,)


@app.cell(hide_code=True)
def _(counted, lesson):
    lesson.check("how-many-double-differences", counted.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    two_v = lesson.ask("two-v")
    lesson.sheet("two-v", two_v)
    return (two_v,)


@app.cell(hide_code=True)
def _(lesson, two_v):
    lesson.check("two-v", two_v.value)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## What can go wrong

    * **A new reference satellite.** When the reference sets, every ambiguity changes its meaning. Keep single-difference ambiguities inside and form the
      differences only when you search for integers: then nothing happens.
    * **Crossing systems.** A receiver delays GPS and Galileo differently, and each receiver in its own way. Difference within a system and within a frequency.
    * **Different data sets.** Two navigation messages of one satellite differ by metres in its clock. Use the same one at both ends.
    * **A slip.** A receiver that loses lock starts counting anew. From then on one double difference is off by whole waves.
    * **Height.** Two receivers at different heights look through different amounts of air. A hundred metres of height cost 3 cm towards the zenith, if you do not model it.
    * **The base's position.** An error of 10 m in the master's own coordinates turns and stretches the baseline by half a millimetre per kilometre.
    * **Less noise?** No. Differencing removes unknowns, never noise. With the right $Q_y$ you lose nothing against solving for all clocks. Without it you do.

    ## Sources

    * S. Wang, Y. Li, X. Sun, Y. Ji: *Dual-antenna attitude determination algorithm based on low-cost receiver*. Journal of
      Computer Applications 39(8), 2381–2385, 2019. Equations (7) to (13).
    * B. Li, S. Song, H. Xia, J. Yang, J. Huang: *Research on post-processing method of dynamic relative positioning data*. Electronic
      Measurement Technology, 2021. Equation (1).
    * X. Yuan, G. Hu, Z. Duan: *Low-cost GPS attitude experiments*, equations (2-1) to (2-3), and C. Yang, X. Yuan: *Carrier-phase differential GPS/inertial
      navigation*, equations (7) and (8). Third annual meeting of the China GPS association, 1998.
    * Real data: `geonet-0759-3040`, GEONET stations of the Geospatial Information Authority of Japan, 2 April 2005, 30 s, from the test data of RTKLIB.
    """)
    return


if __name__ == "__main__":
    app.run()
