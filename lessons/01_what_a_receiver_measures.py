import marimo

__generated_with = "0.25.2"
app = marimo.App(width="medium", app_title="What a receiver measures", html_head_file="head.html")


@app.cell(hide_code=True)
def _():
    import marimo as mo

    from gnsslab.teaching.marimo_front import open_lesson

    lesson = open_lesson("01")
    return lesson, mo


@app.cell(hide_code=True)
def _(lesson):
    lesson.head()
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## The scene

    You stand on a roof in Japan. It is 24 June 2024. One antenna, one receiver. Of all that is in the sky you look at one
    satellite, G20, half-way up in the sky. It moves at almost four kilometres a second, and 21 000 km lie between you.

    Once a second your receiver writes down three numbers. These are real ones:

    | time | code [m] | carrier [cycles] | Doppler [Hz] |
    |---|---|---|---|
    | 08:20:00 | 21&nbsp;276&nbsp;559.872 | 111&nbsp;809&nbsp;054.738 | −1362.500 |
    | 08:20:01 | 21&nbsp;276&nbsp;819.031 | 111&nbsp;810&nbsp;417.391 | −1362.804 |

    The **code** is how long the signal travelled, told in metres. The **carrier** counts the waves of the radio signal, called
    cycles. The **Doppler** says how many cycles a second it should count, with a minus while the satellite goes away.

    In that second the code grew by 259.16 m. The carrier grew by 1362.653 cycles, and a cycle is 0.1903 m long: 259.30 m.
    The mean Doppler says 1362.652 cycles. Three numbers tell of one way, and two of them differ by 14 cm. Which one do you trust?
    Everything in this course is made of them.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## Predict

    Commit to an answer before you see anything. The lab opens once you have chosen.
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

    **First lab: one satellite, five minutes.** In the upper half of the first picture each dot is one second: the code minus the
    carrier. All that both have in common is gone, above all the distance. What stays is how much they disagree.

    The satellite sends on two frequencies, L1 and L2. The red line is the carrier of one minus that of the other, in the same
    metres. In the lower half you see that line enlarged: the scale is in millimetres. You need the second picture for step 5, and
    at the end of the lesson.

    Two words of the controls: *elevation* is the angle of the satellite above the horizon, and *multipath* is the echo of its
    signal from a wall or the ground.
    """)
    return


@app.cell(hide_code=True)
def _(lesson, mo):
    signal = lesson.lab("signal")
    chosen, choose = mo.state(None)
    return choose, chosen, signal


@app.cell(hide_code=True)
def _(choose, lesson, prediction, signal):
    lesson.wait(prediction)
    presets = signal.presets(choose)
    signal.preset_row(presets)
    return (presets,)


@app.cell(hide_code=True)
def _(controls, signal, steering):
    result = signal.run(steering.value, controls.value)
    signal.view(result)
    return (result,)


@app.cell(hide_code=True)
def _(chosen, lesson, prediction, signal):
    lesson.wait(prediction)
    steering = signal.steering(chosen())
    return (steering,)


@app.cell(hide_code=True)
def _(chosen, signal, steering):
    controls = signal.controls(steering.value, chosen())
    signal.panel(steering, controls)
    return (controls,)


@app.cell(hide_code=True)
def _(lesson, prediction, signal):
    lesson.wait(prediction)
    saving = signal.saving()
    signal.saving_row(saving)
    return (saving,)


@app.cell(hide_code=True)
def _(saving, signal):
    signal.link(saving.value)
    return


@app.cell(hide_code=True)
def _(lesson, prediction):
    lesson.text(prediction, r"""
    **What you see.** The dots scatter by 0.4 m. The line looks like a line, because it scatters by 2 mm. That is the whole
    secret of precise positioning: the carrier is 200 times finer than the code.

    Try these, one at a time:

    1. Press **Cycle slip**. The receiver lost its count for a moment, and 5 cycles are in the carrier that never were. From
       there on, every carrier is wrong by the same 0.95 m. The code says nothing. The triangle says: our engine found it.
    2. Move **Cycle slip on L1** to 1. In the dots you see nothing any more. In the enlarged line it is a cliff.
    3. Move **Satellite near elevation** down to 10. Code and carrier both get several times worse.
    4. Press **Multipath**. White noise stands like grass, each dot for itself. An echo goes in slow waves. You can average grass
       away. You cannot average waves away.
    5. Press **Clock jump**. The receiver sets its clock back by a thousandth of a second, which is 300 km of light. Code minus
       carrier does not move at all: the clock is in both. The *range rate* in the second picture shows it, as one spike.
    6. Press **Ionosphere**. Code minus carrier climbs. It climbs along twice the ionosphere; you will see why below.

    **And your answer?** The carrier is finer by a hundred times and more. So why does anybody use the code? Because the
    carrier tells only *changes*. At the first second it says 111 809 054.738 cycles. How many of these really lie between you
    and the satellite? It does not know. One whole number is missing, and it stays missing as long as the count holds.
    """)
    return


@app.cell(hide_code=True)
def _(lesson, prediction):
    lesson.text(prediction, r"""
    ### From one satellite to the whole sky

    **Second lab: all satellites at one time of day.** In the first picture each dot is one code of one satellite, every half
    minute for five minutes. Its height is the *residual*: how far the code is from what it should read at the place where you
    really stand. The horizon is on the left, the zenith on the right. The blue band is one sigma, as the engine expects it: about
    two of three dots should lie in it.

    The second picture is the sky above you: the zenith in the middle, the horizon at the rim, north up. Hollow satellites are not
    used, as they stand below the mask. Of HDOP and VDOP take this for now: they are small when the satellites stand well apart.
    """)
    return


@app.cell(hide_code=True)
def _(lesson, mo):
    sky = lesson.lab("sky")
    chosen_sky, choose_sky = mo.state(None)
    return choose_sky, chosen_sky, sky


@app.cell(hide_code=True)
def _(choose_sky, lesson, prediction, sky):
    lesson.wait(prediction)
    presets_sky = sky.presets(choose_sky)
    sky.preset_row(presets_sky)
    return (presets_sky,)


@app.cell(hide_code=True)
def _(controls_sky, sky, steering_sky):
    result_sky = sky.run(steering_sky.value, controls_sky.value)
    sky.view(result_sky)
    return (result_sky,)


@app.cell(hide_code=True)
def _(chosen_sky, lesson, prediction, sky):
    lesson.wait(prediction)
    steering_sky = sky.steering(chosen_sky())
    return (steering_sky,)


@app.cell(hide_code=True)
def _(chosen_sky, sky, steering_sky):
    controls_sky = sky.controls(steering_sky.value, chosen_sky())
    sky.panel(steering_sky, controls_sky)
    return (controls_sky,)


@app.cell(hide_code=True)
def _(lesson, prediction, sky):
    lesson.wait(prediction)
    saving_sky = sky.saving()
    sky.saving_row(saving_sky)
    return (saving_sky,)


@app.cell(hide_code=True)
def _(saving_sky, sky):
    sky.link(saving_sky.value)
    return


@app.cell(hide_code=True)
def _(lesson, prediction):
    lesson.text(prediction, r"""
    **What you see.** The dots make a fan. Overhead the codes are good to 0.4 m. Near the horizon they miss by one to two
    metres. Low signals come through more air, past more obstacles, and from the weak side of the antenna.

    So away with the low ones? Set **Elevation mask** to 0, 10, 20 and 30 degrees, and watch **VDOP** and the error in height:

    | mask | satellites | VDOP | error in height |
    |---|---|---|---|
    | 0° | 10 | 1.25 | 1.9 m |
    | 10° | 9 | 1.49 | 0.8 m |
    | 20° | 7 | 2.94 | 1.1 m |
    | 30° | 6 | 4.25 | 2.1 m |

    Low satellites hurt, and you need them. With all of them, the worst codes spoil the place. Without them, what is left
    stands close together, and the place gets soft. The best mask is in between, and that is why it is a control.

    Then try these:

    1. Move **Time of day**. The geometry changes within the hour, and HDOP and VDOP with it.
    2. Move **Latitude** to 90. At the pole no GPS satellite rises above 47 degrees.
    3. Press **Noon and stormy**. The ionosphere is twice as strong as the broadcast model says. All low codes are too long, all
       high ones too short, and the height is wrong by 6 m. No scatter warns you.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## Why it works

    Write all in metres. Each symbol links to the [notation](/notation).

    The **code** [$P$](/notation#P) is a time of travel, times the speed of light [$c$](/notation#c). The **carrier**
    [$\Phi$](/notation#Phi) is the phase of the wave: [$\phi$](/notation#phi) cycles, each one wavelength
    [$\lambda$](/notation#lambda) long. On the frequency L1, $\lambda$ is 0.1903 m.

    $$P = \rho + c\,dt_r - c\,dt^s + T + I + \varepsilon_P$$

    $$\Phi = \lambda\phi = \rho + c\,dt_r - c\,dt^s + T - I + \lambda N + \varepsilon_\Phi$$

    $$D = -\dot{\Phi} / \lambda$$

    * [$\rho$](/notation#rho) is the distance. It is what you want.
    * [$dt_r$](/notation#dt_r) is how far your receiver's clock is fast, [$dt^s$](/notation#dt_s) how far the satellite's is. A
      millionth of a second is 300 m.
    * [$T$](/notation#T) is the delay by the air, the troposphere: 2.4 m overhead, 10 m and more near the horizon.
    * [$I$](/notation#I) is the delay by the ionosphere: 1 to 20 m. It has two signs. The code comes late. The carrier's waves
      come early by as much.
    * [$N$](/notation#N) is the whole number of cycles that the carrier does not tell. It is constant until a slip.
    * [$\varepsilon_P$](/notation#epsilon_P) and [$\varepsilon_\Phi$](/notation#epsilon_Phi) are noise and multipath: decimetres in the
      code, millimetres in the carrier.
    * [$D$](/notation#D) is the Doppler in hertz, [$\dot{\Phi}$](/notation#Phi) the change of the carrier a second.

    In words: both measure the distance, made longer by a fast clock here and shorter by a fast clock there, and delayed by the
    air. The carrier is the finer ruler, but nobody tells you at which mark it starts. Doppler is how fast the carrier runs.

    **Subtract them**, and most of it goes:

    $$P - \Phi = 2I - \lambda N + \varepsilon_P - \varepsilon_\Phi$$

    In words: code minus carrier is twice the ionosphere, less a constant, plus the code's noise. A slip of $n$ cycles moves it
    by $-\lambda n$.

    **How our engine finds a slip.** It looks at the carriers of two frequencies. Their difference holds no distance and no
    clock, so it should not move by more than 5 cm within a second. It also looks at the Doppler, which tells how many cycles a
    second should bring, to about one.

    **From ranges to a place.** One satellite gives one equation. The unknowns are east, north, up and the clock: four of them.
    With $m$ satellites you get $m$ equations. Their matrix is [$G$](/notation#G): one row a satellite, minus the unit vector
    [$u$](/notation#u) towards it, and a one for the clock.

    $$G = \begin{pmatrix} -u_1^\top & 1 \\ \vdots & \vdots \\ -u_m^\top & 1 \end{pmatrix}$$

    Least squares solves them. Its $(G^\top G)^{-1}$ says how errors of the codes become errors of the unknowns. On the diagonal
    stand four numbers: $q_e$, $q_n$, $q_u$ for east, north and up, and one for the clock.

    $$\mathrm{HDOP} = \sqrt{q_e + q_n}, \qquad \mathrm{VDOP} = \sqrt{q_u}$$

    $$\sigma_u \approx \mathrm{VDOP} \cdot \sigma_P$$

    In words: [HDOP](/notation#HDOP), on the level, and [VDOP](/notation#VDOP), upwards, say how many metres of place one metre of
    code costs. They know directions only, no noise. VDOP is the larger one: all satellites are above you and none below, so up is
    mixed with the clock. Here $\sigma_P$ is the standard deviation of one code, $\sigma_u$ that of the height.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## The same in nine lines

    Copy this. It reads one observation file and one file of orbits. It shows code minus carrier as the first lab does, and the
    place as the second does.

    ```python
    import gnsslab as gl
    import numpy as np
    from gnsslab.gnss.dense import single_frequency_codes

    observations = gl.read_rinex_obs("rover.obs")
    measured = single_frequency_codes(observations, "G")
    code_minus_carrier = measured.code - measured.phase * measured.wavelength  # [m]
    print(dict(zip(measured.satellites, np.nanstd(code_minus_carrier, axis=0).round(2).tolist())))
    points = gl.solve_points(observations, gl.read_rinex_nav("broadcast.nav"), systems="G", mask_deg=10)
    print(points, points.dop[0].round(2))  # GDOP, PDOP, HDOP, VDOP of the first second
    ```

    No files at hand? `gnsslab simulate static-baseline -o roof` writes some. Go into the folder `roof` first.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## Reach a goal

    The first two belong to the lab of one satellite, the other two to the lab of the sky. They are judged as you move. The slip
    on L2 and the noise of the carrier stand under *more*.
    """)
    return


@app.cell(hide_code=True)
def _(result, signal):
    signal.goal("hidden", result)
    return


@app.cell(hide_code=True)
def _(result, signal):
    signal.goal("finer", result)
    return


@app.cell(hide_code=True)
def _(result_sky, sky):
    sky.goal("high", result_sky)
    return


@app.cell(hide_code=True)
def _(result_sky, sky):
    sky.goal("gps", result_sky)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## Real data

    Set **Data** to *real roof* in both labs. This is the receiver of the scene: five minutes, a survey antenna.

    **One satellite.** Compare with the simulation:

    * The code scatters by a decimetre or two, the carrier by a millimetre. The ratio is again 100 to 400.
    * The code wanders in waves. That is multipath, and it is much stronger here than the white noise.
    * Look at *range rate* in the second picture. The code's is nearly as smooth as the carrier's: this receiver smooths its code,
      with the carrier's help, before it writes it down. Receivers do that, and seldom say so.
    * Nobody knows $\rho$ and $dt_r$ here, so both are computed from the codes. What the equation leaves wanders by half a metre:
      that is the code's noise, seen through the clock.

    **The whole sky.** Set **Systems** to *all*. The fan is there. But the codes of one satellite lie in a heap, and the heap is off
    by one to four metres. That is no noise: it is what broadcast orbits, clocks and the ionosphere's model leave. It does not
    average out, and it is nearly the same for a second receiver nearby. The next lesson lives on that.

    *GEONET* is another receiver, in the year 2021, for one minute. It travels with the course, so it works without a network. It
    writes no Doppler. To use your own, choose *my files*: one observation file and one of broadcast orbits, in RINEX.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## Find the printed error

    **Equation (1) of a paper of 2021** gives the carrier of one receiver. In our letters it reads

    $$\lambda\phi = \rho - c\,dt_r + c\,dt^s - \lambda N - I - T$$

    It calls $dt_r$ and $dt^s$ clock errors, and $I$ and $T$ delays. Compare it with the equation above. Then set **Clock** to
    *free* and **Equation of the carrier** (under *more*) to *as printed*, or press **As printed** in the first lab. *Carrier less its
    equation*, in the second picture, shows what the equation leaves. Corrected, it is one constant, $\lambda N$. As printed, it
    runs away by 60 m a second.

    Which terms have the wrong sign? Both clocks and the troposphere. The sign of $N$ is a matter of how you count, and the
    ionosphere is right. Now read every term as a *correction*, an error with its sign turned round: all come right. So it is a
    question of words, and a formula does not carry its words with it. In the paper it did no harm. It takes differences of two
    receivers and two satellites, and there the clocks cancel whatever their sign.

    **A number in a paper of 1998.** It sets the sigma of the code on L1, the C/A code, to **3 cm** for one make of receiver,
    and a few lines on to **3 m** for another. Press **As printed** in the lab of the sky, or set **Sigma promised** (under *more*). With 3 cm the band
    is a hair line, one code in a hundred lies in it, and the place is promised to 3 cm while it is off by half a metre. With
    3 m the promise is safe. Even the best C/A code of that time was not good to 3 cm: the unit is wrong.

    How do you catch a wrong unit? Do not look at the place. Look at the residuals: two of three must lie within one sigma.
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
    slip = lesson.ask("slip-in-metres")
    lesson.sheet("slip-in-metres", slip)
    return (slip,)


@app.cell(hide_code=True)
def _(lesson, slip):
    lesson.check("slip-in-metres", slip.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    doubled = lesson.ask("ionosphere-from-code-minus-carrier")
    lesson.sheet("ionosphere-from-code-minus-carrier", doubled)
    return (doubled,)


@app.cell(hide_code=True)
def _(doubled, lesson):
    lesson.check("ionosphere-from-code-minus-carrier", doubled.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    fast = lesson.ask("microseconds-of-light")
    lesson.sheet("microseconds-of-light", fast)
    return (fast,)


@app.cell(hide_code=True)
def _(fast, lesson):
    lesson.check("microseconds-of-light", fast.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    speed = lesson.ask("speed-from-doppler")
    lesson.sheet("speed-from-doppler", speed)
    return (speed,)


@app.cell(hide_code=True)
def _(lesson, speed):
    lesson.check("speed-from-doppler", speed.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    low = lesson.ask("sigma-of-a-low-satellite")
    lesson.sheet("sigma-of-a-low-satellite", low)
    return (low,)


@app.cell(hide_code=True)
def _(lesson, low):
    lesson.check("sigma-of-a-low-satellite", low.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    mean = lesson.ask("mean-of-a-hundred")
    lesson.sheet("mean-of-a-hundred", mean)
    return (mean,)


@app.cell(hide_code=True)
def _(lesson, mean):
    lesson.check("mean-of-a-hundred", mean.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    printed_run = lesson.ask("run-away-of-the-printed-equation")
    lesson.sheet("run-away-of-the-printed-equation", printed_run)
    return (printed_run,)


@app.cell(hide_code=True)
def _(lesson, printed_run):
    lesson.check("run-away-of-the-printed-equation", printed_run.value)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## What can go wrong

    * **Cycles or metres?** RINEX files hold the carrier in cycles and the code in metres. Multiply by the wavelength of *that*
      satellite's frequency, once.
    * **The sign of the Doppler.** Positive means nearer. Some receivers write it the other way round; compare it with the
      carrier, as the scene does.
    * **A slip on both frequencies.** One cycle on L1 and one on L2 move their difference by 54 mm only. Low satellites are
      noisier than that.
    * **Half a cycle.** Some receivers do not know the sign of the wave at first, and their carrier is off by 0.095 m until they
      do. Files have a flag for it.
    * **A smoothed code** looks better than it is. Its errors last for a minute or more, so averaging helps little.
    * **DOP is no error.** It says what the geometry does to an error. With bad codes, a DOP of 1 is still bad.
    * **Clock jumps.** Cheap receivers set their clock by whole milliseconds. Code and carrier jump by 300 km together, and a
      detector that looks at one satellite alone cries slip.

    ## Sources

    * B. Li, S. Song, H. Xia, J. Yang, J. Huang: *Research on post-processing method of dynamic relative positioning data*.
      Electronic Measurement Technology, 2021. Equation (1).
    * X. Yuan, G. Hu, Z. Duan: low-cost GPS attitude experiments. China GPS Association, third annual meeting, 1998.
    * Real data: `matrtklib-static` from MatRTKLIB by Taro Suzuki (MIT licence); `cssrlib-078` from cssrlib (MIT licence), its
      base a station of GSI's GEONET.
    * IS-GPS-200N: the signals, the broadcast orbits and the ionosphere's model of GPS.
    * RINEX: the format of the files, IGS and RTCM, version 3.04, 2018.
    """)
    return


if __name__ == "__main__":
    app.run()
