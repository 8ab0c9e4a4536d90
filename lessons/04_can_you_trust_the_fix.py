import marimo

__generated_with = "0.25.2"
app = marimo.App(width="medium", app_title="Can you trust the fix?", html_head_file="head.html")


@app.cell(hide_code=True)
def _():
    import marimo as mo

    from gnsslab.teaching.marimo_front import open_lesson

    lesson = open_lesson("04")
    return lesson, mo


@app.cell(hide_code=True)
def _(lesson):
    lesson.head()
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## The scene

    A roof in Nagoya, two antennas, **0.99 m** apart. Five GPS satellites, one frequency. You solve each epoch alone. At the 25th the software says:

    * the best whole numbers fit **ten times** better than the second best: ratio 10.1, where it asks for 3;
    * so the solution is *fixed*, and its sigmas are 6 mm, 13 mm and 17 mm.

    It is off by **36 cm**.

    Nothing was broken. The receivers were good, the sky was open, the test was the one that nearly every program uses. This lesson is about the question that
    the software did not ask: how often is such a fix right? You can know that before you measure anything.

    It is a long lesson, best in two sittings of three quarters of an hour. The first ends before *Not all, not none*.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## Predict

    On that roof 101 epochs were solved with five satellites, each alone. Thirteen passed the test. Commit to an answer before you see anything. The labs open once you
    have chosen.
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

    Ten thousand epochs are drawn from a model: satellites, frequencies, noise. Each is fixed to the nearest whole numbers, and here you know which are the true ones.

    **The first picture** has the ratios of all epochs, the second best squared distance over the best. Dark blue is fixed and right, orange hatched is **fixed and wrong**, the light colours were rejected by the test.
    The axis is logarithmic, so that you can see one wrong fix in ten thousand. The bars below compare your test, on top, with four others: no test; a ratio of 3; the rule of our own engine, $1 + 16/n$, which asks for less
    where there are more ambiguities ($n$ of them); and a fixed failure rate, which step 2 explains.

    **The second picture** has on top what was *counted*, and below what was *promised* before any epoch was drawn: two estimates, and three pairs of a lower and an upper bound (green).
    """)
    return


@app.cell(hide_code=True)
def _(lesson, mo):
    trust = lesson.lab("trust")
    chosen, choose = mo.state(None)
    return choose, chosen, trust


@app.cell(hide_code=True)
def _(choose, lesson, prediction, trust):
    lesson.wait(prediction)
    presets = trust.presets(choose)
    trust.preset_row(presets)
    return (presets,)


@app.cell(hide_code=True)
def _(controls, steering, trust):
    result = trust.run(steering.value, controls.value)
    trust.view(result)
    return (result,)


@app.cell(hide_code=True)
def _(chosen, lesson, prediction, trust):
    lesson.wait(prediction)
    steering = trust.steering(chosen())
    return (steering,)


@app.cell(hide_code=True)
def _(chosen, steering, trust):
    controls = trust.controls(steering.value, chosen())
    trust.panel(steering, controls)
    return (controls,)


@app.cell(hide_code=True)
def _(lesson, prediction, trust):
    lesson.wait(prediction)
    saving = trust.saving()
    trust.saving_row(saving)
    return (saving,)


@app.cell(hide_code=True)
def _(saving, trust):
    trust.link(saving.value)
    return


@app.cell(hide_code=True)
def _(lesson, prediction):
    lesson.text(prediction, r"""
    **What you see.** The model promises 88.7 %, and 93.6 % are right. The promise is a lower bound, and the count lies above it. A ratio of 3 stops nearly all wrong fixes. It also throws
    away more than half of the right ones.

    Try these, one at a time:

    1. Move **Threshold** to 1, then up. There is no value that stops only wrong fixes: right ones always go with them.
    2. Set **Test** to *fixed failure rate*. You no longer choose a ratio but what you can bear: 1 % of all epochs fixed wrong. The model itself gives the ratio, 1.54, and
       twice as many epochs are fixed.
    3. Press **21 ambiguities**: 97 % are right, and a ratio of 3 rejects nearly all of them. Press **Weak model**: three of four are wrong, and of those that
       pass half are wrong. *The same 3.* A ratio means nothing until you know the model.
    4. Press **Multipath**. An echo makes one satellite's code 2.5 m too long, and the model does not know. ADOP promises 99.97 %, and 44 % are wrong. Here a ratio of 3 lets hardly any epoch pass. Then press **Multipath, tolerated**:
       the fixed failure rate fixes them all, as it believes the same model. Press **All fixes wrong**: with five satellites and another echo the ratio lets a tenth of the epochs pass, and every one of them is wrong.

    The last four buttons belong to *What a test decides* and *Find the printed error*.

    **And your answer?** Press **Start**, and move **Satellites** to 5. Of all epochs 15.5 % pass, and 14.4 % pass and are wrong: more than nine of ten that pass. On the roof it
    was **eight of the thirteen**. Those receivers are better than this model, but five satellites are too few all the same.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## Why it works

    ### What is promised

    Lesson 03 found the whole numbers. The float ambiguities [$\hat a$](/notation#a_hat) scatter about the true ones with the covariance [$Q_a$](/notation#Q_a). A fix is right if they stay in the
    cell of the true ones. How often they do depends on $Q_a$ alone, and $Q_a$ depends on where the satellites are and how noisy the readings: no measurement is needed.

    **Bootstrapping.** Round one ambiguity after the other, each corrected by those before. One alone is right if its error is less than half a cycle. With the conditional variances
    [$d_i$](/notation#d) after decorrelation (what is left of each when those before it are known), and [$n$](/notation#n) ambiguities:

    $$P_s = \prod_{i=1}^{n} \left( 2\,\Phi\!\left(\frac{1}{2\sqrt{d_i}}\right) - 1 \right)$$

    In words: [$P_s$](/notation#P_s), the *success rate*, is the chance that all of them are right; [$\Phi$](/notation#Phi) is the normal distribution function. Least squares is right at least as often. So this
    is a lower bound that costs nothing.

    **ADOP.** Put one sigma in the place of all, the geometric mean of the $\sqrt{d_i}$:

    $$\begin{aligned} \mathrm{ADOP} & = (\det Q_a)^{1/(2n)} \\ P_s & \approx \left( 2\,\Phi\!\left(\frac{1}{2\,\mathrm{ADOP}}\right) - 1 \right)^{n} \end{aligned}$$

    In words: as if all ambiguities were equally uncertain. It is a good guess where decorrelation has made the $d_i$ alike. Bootstrapping is never better than that. Least squares may be better or worse, so for the fix itself it is no bound.

    **Bounds.** The green bars of the second picture hold the success rate of least squares for certain. They come from the variances and the volume of the ellipsoid (*variances and ADOP*), from how far the cell reaches (*pull-in region*), or from the longest and the shortest axis of the ellipsoid (*eigenvalues*). Where
    a bar is long, it says little.

    **Counting.** Draw $N$ float vectors, fix each, and count the right ones. The count has an error of its own, $\sqrt{P_s (1 - P_s) / N}$. With 10 000 epochs a rate of 90 % is good to 0.3 %.

    All of them ask the *model*. If a reflection moves $\hat a$ by half a cycle, they do not see it. Only the measurements could tell, and with few satellites not even they can.

    ### What a test decides

    Let $\check a$ be the best whole numbers and $\check a_2$ the second best. The *ratio* [$R$](/notation#R) compares how far they are from the float ones:

    $$R = \frac{\|\hat a - \check a_2\|^2}{\|\hat a - \check a\|^2} \ge c, \qquad \|x\|^2 = x^{\mathsf T}\, Q_a^{-1}\, x$$

    In words: how many times farther away is the second best, in squared distance? If at least [$c$](/notation#c) times, believe the best. The ratio is not the probability of anything.

    Look at the scene: the squared distances were **0.010 and 0.104**. The true whole numbers have about 4 on average, one for each ambiguity, if the noise is as large as assumed. These receivers are better, and theirs have about 0.6. So *both* fit better than the truth
    usually does: with so many vectors near the float one, some come close by chance. How many times more probable the best is depends on the *difference*:

    $$\frac{P(\check a)}{P(\check a_2)} = \exp\frac{0.104 - 0.010}{2}$$

    That is nearly one: as good as even, at a ratio of ten. (Question 6 asks you for the number.)

    A test sorts all epochs into four: fixed and right, **fixed and wrong** (the *failure*), rejected though right, rejected and wrong. Only you know what you can bear. The **fixed failure rate test** takes
    that as given. It looks for the smallest $c$ with which no more than a share [$P_f$](/notation#P_f) of all epochs fails:

    $$P(R \ge c\ \text{and}\ \check a \text{ wrong}) \le P_f, \qquad c \ge 1$$

    In words: draw epochs from the model, sort the ratios of the wrong ones, and cut where few enough are left. For a strong model the answer is 1: no test is needed. For a weak one it may
    be 10. Where there is no time to draw, tables give $c$ for $n$ and the failure rate without a test.

    Two more tests are in the lab. The *difference test* asks for a difference of the squared distances, so for odds. The *projector test* asks how far $\hat a$ lies from $\check a$ on the way to
    $\check a_2$. None of the three is best in every model, and none can make a wrong fix right.
    """)
    return


@app.cell(hide_code=True)
def _(lesson, prediction):
    lesson.text(prediction, r"""
    ### Not all, not none

    A fix that the test rejects sends you back to float, and all whole numbers are thrown away. Why all? There are two ways in between.

    **Partly fixed.** After decorrelation some combinations are known to a hundredth of a cycle, others to a third. Fix the certain ones. **Best equivariant.** Do not choose at all. Take the mean
    of *all* whole-number vectors, each as heavy as it is probable.

    **The first picture.** Begin with the stairs at the lower left: one ambiguity, its float value, and what becomes of it. Above: how far the baselines of 2000 epochs are off, for five ways of treating the *same* float
    solutions; a line farther left is better. At the lower right: the risk that at least one is wrong, if you fix one, two, three and more of them; what is below the dashed line may be fixed. **The second picture** is again one ambiguity, for all sigmas.
    """)
    return


@app.cell(hide_code=True)
def _(lesson, mo):
    soft = lesson.lab("soft-fixing")
    chosen_soft, choose_soft = mo.state(None)
    return choose_soft, chosen_soft, soft


@app.cell(hide_code=True)
def _(choose_soft, lesson, prediction, soft):
    lesson.wait(prediction)
    presets_soft = soft.presets(choose_soft)
    soft.preset_row(presets_soft)
    return (presets_soft,)


@app.cell(hide_code=True)
def _(controls_soft, soft, steering_soft):
    result_soft = soft.run(steering_soft.value, controls_soft.value)
    soft.view(result_soft)
    return (result_soft,)


@app.cell(hide_code=True)
def _(chosen_soft, lesson, prediction, soft):
    lesson.wait(prediction)
    steering_soft = soft.steering(chosen_soft())
    return (steering_soft,)


@app.cell(hide_code=True)
def _(chosen_soft, soft, steering_soft):
    controls_soft = soft.controls(steering_soft.value, chosen_soft())
    soft.panel(steering_soft, controls_soft)
    return (controls_soft,)


@app.cell(hide_code=True)
def _(lesson, prediction, soft):
    lesson.wait(prediction)
    saving_soft = soft.saving()
    soft.saving_row(saving_soft)
    return (saving_soft,)


@app.cell(hide_code=True)
def _(saving_soft, soft):
    soft.link(saving_soft.value)
    return


@app.cell(hide_code=True)
def _(lesson, prediction):
    lesson.text(prediction, r"""
    **What you see.** Float is a line and rounding a staircase. The best equivariant estimate is a staircase with round edges: close to an integer it rounds, half-way between two it hesitates. Move **Sigma of one ambiguity**
    from 0.05 to 0.6: steps become a ramp. It decides by itself how far to trust the integers.

    1. At the start 97.7 % of the fixes are right. The rest are off by about a metre, and they make the rms: 0.16 m. The best equivariant has 0.14 m. It has a price: fewer
       epochs are below 2 cm, 82 % instead of 96 %.
    2. Press **One noisy satellite**. One of eight is four times as noisy, as behind trees. One combination with its two ambiguities stays uncertain. The ratio test looks at all fourteen at once, so it lets only 11.8 % of the epochs pass: half a metre. Fix **13 of the 14**, and it
       is 8 mm. Always fixing gives 8 mm as well: the noisy satellite weighs so little that a wrong integer there does no harm. The ratio cannot tell.
    3. Press **Single ones**: ambiguities as they stand in the model, at a stricter risk. None can be fixed, as the same uncertain part is in each of them. Set **Partly fixed are** (under *more*) to *combinations*: 11 can, as decorrelation puts that part into the other three.
       The best equivariant has 12 mm here, and always fixing 9 mm: 2000 epochs are not the long run. Set **Seed** to 3. Now one fix is more than a metre off, and it is 32 mm against 33 mm.
    4. Press **Better left alone**. Most fixes are wrong, and always fixing is worse than never fixing. For one ambiguity, in the second picture, that begins at 0.29 cycles: there the blue line rises above 1.
    5. Press **Start**, and move **Risk of the partial fix**. A smaller risk fixes fewer, and the dashed orange line moves right.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ### The equations: partly fixed, best equivariant

    **Partly fixed.** Let [$z$](/notation#z) be the last of the decorrelated ambiguities, as many as have a success rate of $1 - P_f$ together; $P_f$ is the risk that you accept. Least squares makes them whole, [$\check z$](/notation#z_fix), and all others follow by their correlation, just as the baseline does, with the covariances [$Q_z$](/notation#Q_z) and [$Q_{bz}$](/notation#Q_bz):

    $$\check b = \hat b - Q_{bz}\, Q_z^{-1}\, (\hat z - \check z)$$

    In words: what is fixed pulls along what is not. Nothing fixed gives [$\hat b$](/notation#b_hat), all fixed gives [$\check b$](/notation#b_fix) of lesson 03.

    **Best integer equivariant** (BIE). Given $\hat a$, how probable is it that the true vector is $a$? That is its weight [$w_a$](/notation#w_a), and the estimate [$\bar a$](/notation#a_bar) is the mean:

    $$\bar a = \frac{\sum_a a\, w_a}{\sum_a w_a}, \qquad w_a = \exp\left(-\tfrac12 \|\hat a - a\|^2\right)$$

    In words: every whole-number vector has a vote, and the near ones have the most. Add whole numbers to $\hat a$, and $\bar a$ moves by the same: that is what *equivariant* means. Float and fixed do so too. Among all estimates that do, none has a smaller mean squared error. So it is never worse than float and
    never worse than fixed, in the long run. The price: nobody can say that it *is* fixed.
    """)
    return


@app.cell(hide_code=True)
def _(lesson, prediction):
    lesson.text(prediction, r"""
    ### The known length

    There is one more thing you know. Two antennas on a beam are as far apart as the beam is long, and that does not change. There are two places to put the length in.

    **As a row.** One more row among the measurements of the float solution: the baseline is 1 m long. A length is not linear in east, north and up, so the row is linearised at the float baseline, and that
    is off by nearly a metre. **In the search.** Ask each vector of whole numbers: how near does *your* baseline come to that length?

    **The first picture** is a map: the baselines that belong to the whole numbers nearest to the float ones, seen from above, and the circle of the length. **The second picture**: how well each of them fits and how long it is; below, how often
    each method is right, and by a diamond how often it *claims* to be.
    """)
    return


@app.cell(hide_code=True)
def _(lesson, mo):
    length = lesson.lab("known-length")
    chosen_length, choose_length = mo.state(None)
    return choose_length, chosen_length, length


@app.cell(hide_code=True)
def _(choose_length, length, lesson, prediction):
    lesson.wait(prediction)
    presets_length = length.presets(choose_length)
    length.preset_row(presets_length)
    return (presets_length,)


@app.cell(hide_code=True)
def _(controls_length, length, steering_length):
    result_length = length.run(steering_length.value, controls_length.value)
    length.view(result_length)
    return (result_length,)


@app.cell(hide_code=True)
def _(chosen_length, length, lesson, prediction):
    lesson.wait(prediction)
    steering_length = length.steering(chosen_length())
    return (steering_length,)


@app.cell(hide_code=True)
def _(chosen_length, length, steering_length):
    controls_length = length.controls(steering_length.value, chosen_length())
    length.panel(steering_length, controls_length)
    return (controls_length,)


@app.cell(hide_code=True)
def _(length, lesson, prediction):
    lesson.wait(prediction)
    saving_length = length.saving()
    length.saving_row(saving_length)
    return (saving_length,)


@app.cell(hide_code=True)
def _(length, saving_length):
    length.link(saving_length.value)
    return


@app.cell(hide_code=True)
def _(lesson, prediction):
    lesson.text(prediction, r"""
    **What you see.** Six satellites, L1, one epoch. Without the length 31.5 % are right. With the length in the search it is **96 %**. On the map are the two dozen vectors nearest to the float one, and only one of them has a baseline
    of one metre.

    1. Set **Length goes into** to *the float solution, as a row*: 11 % are right. The row has made it worse, and claims 84 %.
    2. Set it to *row and search: twice*. It claims 98.5 %, and 22 % are right. What you know counts once. Count it twice, and you are sure of what is wrong.
    3. Set it back to *the search, exactly*, and move **You enter too much by** to 5 cm. Not one epoch is right, and it still claims 87 %. A hard constraint must be true.
    4. Press **30 cm**: 98.5 %. The shorter the beam, the better, as fewer vectors come near the smaller sphere.
    5. Press **Nine satellites**: without the length it works as well. The length helps where there are few satellites.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ### The equations of the length

    **Why the row fails.** The float baseline is off by half a metre *across* the beam as well. A vector of a metre, moved half a metre sideways, is 12 cm too long: an error that no sigma knows of. And its direction is wrong by 27°, so the row pulls in a wrong direction.
    A row is fine once the baseline is known much better than it is long.

    **C-LAMBDA** (constrained). Each vector of whole numbers $a$ has a baseline of its own, $\hat b(a)$, with the covariance [$Q_{b|a}$](/notation#Q_b_given_a). The cost of $a$ now has two parts. The second is how far that baseline is from the sphere of radius
    [$\ell$](/notation#ell):

    $$\check a = \arg\min_a \left( \|\hat a - a\|^2_{Q_a} + \min_{\|b\| = \ell} \|\hat b(a) - b\|^2_{Q_{b|a}} \right)$$

    In words: fit the float ambiguities *and* have the right length. The search walks through the same tree as in lesson 03. The first part alone never costs more than both, so it still says which branches to leave.

    **The nearest point of a sphere** (leave it out at first reading). The error ellipsoid of $\hat b(a)$ is no ball: it is longest upwards. So the nearest point is not the one you get by stretching $\hat b(a)$. Along the ellipsoid's axes, with the sigmas $\sigma_i$:

    $$b_i = \frac{\hat b_i}{1 + \kappa\, \sigma_i^2}, \qquad \sum_i \left( \frac{\hat b_i}{1 + \kappa\, \sigma_i^2} \right)^2 = \ell^2$$

    In words: each coordinate gives way as far as it is uncertain. One number [$\kappa$](/notation#kappa) decides how far, and the second equation, the *secular equation*, gives it. Its left side falls as $\kappa$ grows, so there is one root to find, and a few steps of Newton find it. (Where $\hat b$ is at right angles to the longest axis, two points may be equally near. This *hard case* has a solution of its own.)
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## The same in a few lines

    Copy this. One epoch of L1 and six satellites, two antennas a metre apart.

    ```python
    import numpy as np
    import gnsslab as gl

    el, az = np.radians([[68, 52, 16, 12, 62, 37], [186, 281, 94, 226, 71, 146]])
    u = np.stack([np.cos(el) * np.sin(az), np.cos(el) * np.cos(az), np.sin(el)], axis=1)
    sigma = 1 / (0.2 + np.sin(el))  # low satellites are noisier
    A, B, Q_y = gl.short_baseline_model(u, [0.1903], 0.2 * sigma, 0.002 * sigma)
    rng = np.random.default_rng(7)
    noise = np.linalg.cholesky(Q_y) @ rng.standard_normal(len(Q_y))
    flt = gl.solve_float(A @ [34, -28, -45, -20, -22] + B @ [0.0, 0.8, 0.6] + noise, A, B, Q_y)
    print(gl.success_rate(flt.Q_a), gl.adop(flt.Q_a), gl.simulate_success(flt.Q_a, rng))
    best = gl.integer_least_squares(flt.a_hat, flt.Q_a)
    test = gl.failure_rate_threshold(flt.Q_a, 0.01, rng)  # one epoch of a hundred may be fixed wrong
    print(best.best, best.ratio, test, gl.ratio_test(best.norms, test.ratio))
    print(gl.fix_most_certain(flt.a_hat, flt.Q_a, success_rate=0.99))
    print(gl.best_integer_equivariant(flt.a_hat, flt.Q_a).a.round(2))
    print(gl.fix_with_length(flt, 1.0).best)
    ```

    The true whole numbers are 34, −28, −45, −20, −22. Least squares misses them here, and the test says so: the ratio is 2.2, and this model asks for more than 4. No combination is certain enough to be fixed alone (0 of 5). With the length they are found.
    `gl.fix_with_length(gl.use_length(flt, 1.0, 0.005), 1.0)` is refused: the length would be used twice.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## Reach a goal

    Two for the first lab, two for the second, two for the third; the last lab, under *Real data*, has one of its own. They are judged as you move. Some controls that help are under *more*.
    """)
    return


@app.cell(hide_code=True)
def _(result, trust):
    trust.goal("careful", result)
    return


@app.cell(hide_code=True)
def _(result, trust):
    trust.goal("biased", result)
    return


@app.cell(hide_code=True)
def _(result_soft, soft):
    soft.goal("worse-than-nothing", result_soft)
    return


@app.cell(hide_code=True)
def _(result_soft, soft):
    soft.goal("in-the-wood", result_soft)
    return


@app.cell(hide_code=True)
def _(length, result_length):
    length.goal("five", result_length)
    return


@app.cell(hide_code=True)
def _(length, result_length):
    length.goal("honest", result_length)
    return


@app.cell(hide_code=True)
def _(lesson, prediction):
    lesson.text(prediction, r"""
    ## Real data

    Now the roof. Nobody simulated this. Each epoch is solved alone, and the true position is known from all of them together. Satellites are taken away one by one, the lowest first.

    **The first picture**: what became of all epochs with nine satellites left, with eight, and so on. The diamond is what the model promised. **The second picture**: each epoch's error, with the number of satellites that you choose.
    """)
    return


@app.cell(hide_code=True)
def _(lesson, mo):
    fewer = lesson.lab("fewer-satellites")
    chosen_fewer, choose_fewer = mo.state(None)
    return choose_fewer, chosen_fewer, fewer


@app.cell(hide_code=True)
def _(choose_fewer, fewer, lesson, prediction):
    lesson.wait(prediction)
    presets_fewer = fewer.presets(choose_fewer)
    fewer.preset_row(presets_fewer)
    return (presets_fewer,)


@app.cell(hide_code=True)
def _(controls_fewer, fewer, steering_fewer):
    result_fewer = fewer.run(steering_fewer.value, controls_fewer.value)
    fewer.view(result_fewer)
    return (result_fewer,)


@app.cell(hide_code=True)
def _(chosen_fewer, fewer, lesson, prediction):
    lesson.wait(prediction)
    steering_fewer = fewer.steering(chosen_fewer())
    return (steering_fewer,)


@app.cell(hide_code=True)
def _(chosen_fewer, fewer, steering_fewer):
    controls_fewer = fewer.controls(steering_fewer.value, chosen_fewer())
    fewer.panel(steering_fewer, controls_fewer)
    return (controls_fewer,)


@app.cell(hide_code=True)
def _(fewer, lesson, prediction):
    lesson.wait(prediction)
    saving_fewer = fewer.saving()
    fewer.saving_row(saving_fewer)
    return (saving_fewer,)


@app.cell(hide_code=True)
def _(fewer, saving_fewer):
    fewer.link(saving_fewer.value)
    return


@app.cell(hide_code=True)
def _(lesson, prediction):
    lesson.text(prediction, r"""
    **It breaks all at once.** With nine satellites all epochs are right, with six nine of ten, with five **one of four**. With one frequency and one epoch, $m$ satellites give
    $2(m - 1)$ double differences for $m - 1$ ambiguities and 3 coordinates. So $m - 4$ of them are left to check the rest: five with nine satellites, one with five, none with four.

    * Move **Satellites left** to 5. This is the scene. Thirteen epochs pass a ratio of 3, eight of them wrong. Epoch 25 is among them, off by 0.36 m.
    * Set **Believe** to *failure rate*. The model asks for a ratio of 11 here, and none of the wrong ones gets through. None of the right ones does either: with five satellites and one frequency there is nothing to be believed.
    * Press **The length known**. The same measurements, and 99 % are right.
    * Press **Two frequencies**: four satellites give the right integers at every epoch. That is not yet a good position: the geometry of these four is so poor that it is off by metres at first, with the right integers.
    * Press **Two stations**, Japan, 3.3 km apart: more noise, and it breaks at five as well.
    * The promises are far too low, because the noise we assume, 30 cm for the code and 3 mm for the carrier, is twice that of these receivers. Press **Half the noise**. No integer changes and no ratio, as these depend only on how code and carrier compare. But now the promises come close to
      the counts. A promise is as good as its sigmas. One that is too low costs fixes, one that is too high costs you the position.

    Set **Data** to *my files* for your own measurements: two receivers that stand still, and broadcast orbits.
    """)
    return


@app.cell(hide_code=True)
def _(fewer, result_fewer):
    fewer.goal("roof-five", result_fewer)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## Reproduce

    Published numbers, and what our functions give. Counts have their standard deviation. Three rows marked * have no paper behind them: see below.

    | what, and who | elsewhere | here |
    |:---|---|---|
    | success rate of bootstrapping, two ambiguities as they are (LAMBDA 4.0, example 2) | 90.41 % | 90.41 % |
    | the same after decorrelation | 97.08 % | 97.08 % |
    | bounds by the pull-in region | 94.90 to 97.13 % | 94.90 to 97.13 % |
    | bounds by the eigenvalues, after decorrelation | 96.35 to 97.70 % | 96.35 to 97.70 % |
    | one epoch of L1, success rate (example 3) | 30.7 % | 30.7 % |
    | squared error of the baseline, fixed over float (example 3, 10 000 draws) | 1.231 | 1.219 ± 0.003 |
    | the same, best equivariant over float | 0.903 | 0.897 ± 0.001 |
    | one epoch of L1, length 1 m: right without it* (3000 draws there, 6000 here) | 31.6 % | 31.7 % ± 0.6 % |
    | the same: right with it in the search* | 95.6 % | 95.8 % ± 0.3 % |
    | threshold $\mu$ (best over second) for 1 % of failures, where without a test 5 and 10 % fail, $n = 8$ (LAMBDA 3.0) | 0.65 and 0.55 | 0.65 at 6.4 % |
    | ADOP 0.14 and 0.20, $n = 28$: success rate | 0.990 and 0.705 | 0.990 and 0.705 |
    | multipath that the model ignores*: promised by ADOP; wrong | 100 %; 42 to 44 % | 99.97 %; 44.3 % |

    They agree: 1.231 was drawn 10 000 times, so it has an error of 0.012 of its own.

    * **The known length.** No paper prints this pair. It was counted once by brute force, for this course.
    * **Thresholds.** [$\mu$](/notation#mu) is best over second. At the start of the first lab 6.4 % fail without a test, and our threshold for 1 % is 1.54, so 1/1.54 = 0.65. Between its two entries the table asks for about 0.62 there, which is a little stricter.
    * **Multipath.** The paper of 2015 judges its schemes by their ADOP, and gives no share of wrong fixes. We simulated its voyage, with the bursts of multipath that it reports: plain least squares had an ADOP of 0.0755, which promises
      everything, and 42 to 44 % of the best vectors were wrong. **Multipath** in the first lab shows the same with one echo, whose size was chosen to do so. A smaller ADOP means a better geometry. It does not mean fewer wrong fixes.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## Find the printed error

    **The ratio upside down.** Three of the five papers behind this course ask the ratio to reach 3 or 4, or 2 to 3, and none writes down what is divided by what. RTKLIB divides the second best by the best and asks for *at least* 3. TU Delft's LAMBDA divides the best by the second best and
    asks for *at most* $\mu$. Mix them up, and this comes out. Press **Upside down** and **1/3 for 3** in the first lab, where 93.6 % are right (**Ratio written** under *more* does it):

    | the ratio is | fixed | fixed wrong |
    |:---|---|---|
    | second over best, at least 3 | 40.1 % | 0.03 % |
    | upside down: best over second, at least 1/3 | 59.9 % | 6.4 % |
    | 1/3 given where 3 was meant | 100 % | 6.4 % |

    Upside down, exactly the doubtful fixes pass: nearly all of the wrong ones, and not one of the certain ones. It looks good: more epochs are fixed than before.

    **Paper of 2019, equation (16).** Printed: the variance of the length row is the *length* squared. It should be $\sigma_b^2$, where [$\sigma_b$](/notation#sigma_b) says how well the length is known. With a beam of 1.167 m, known to 5 mm, the row's sigma is 233 times too large, and the row does nothing: a sigma
    of 10 mm along the beam stays at 10.0 mm, where it should become 4.5 mm. Move **Sigma of the row** in the third lab, under *more*, to 50 cm, and see a row fade. But at 20 cm the row does *better* than at 5 mm, 45 % against 11 %: with 5 mm it believes its linearisation too much. So one mistake hides another.

    **Used twice.** Nobody prints this one; it is what happens when a filter with a length row hands its float solution to a search with a length. 22 % right, 98.5 % claimed. Our float solutions remember what has gone into them, and the search refuses.
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
    one = lesson.ask("success-rate-of-one")
    lesson.sheet("success-rate-of-one", one)
    return (one,)


@app.cell(hide_code=True)
def _(lesson, one):
    lesson.check("success-rate-of-one", one.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    many = lesson.ask("adop-and-many")
    lesson.sheet("adop-and-many", many)
    return (many,)


@app.cell(hide_code=True)
def _(lesson, many):
    lesson.check("adop-and-many", many.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    turned = lesson.ask("mu-turned-round")
    lesson.sheet("mu-turned-round", turned)
    return (turned,)


@app.cell(hide_code=True)
def _(lesson, turned):
    lesson.check("mu-turned-round", turned.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    day = lesson.ask("failures-a-day")
    lesson.sheet("failures-a-day", day)
    return (day,)


@app.cell(hide_code=True)
def _(day, lesson):
    lesson.check("failures-a-day", day.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    count = lesson.ask("error-of-a-count")
    lesson.sheet("error-of-a-count", count)
    return (count,)


@app.cell(hide_code=True)
def _(count, lesson):
    lesson.check("error-of-a-count", count.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    odds = lesson.ask("odds-of-a-ratio-of-ten")
    lesson.sheet("odds-of-a-ratio-of-ten", odds)
    return (odds,)


@app.cell(hide_code=True)
def _(lesson, odds):
    lesson.check("odds-of-a-ratio-of-ten", odds.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    believed = lesson.ask("wrong-of-those-believed")
    lesson.sheet("wrong-of-those-believed", believed)
    return (believed,)


@app.cell(hide_code=True)
def _(believed, lesson):
    lesson.check("wrong-of-those-believed", believed.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    mean = lesson.ask("best-equivariant-of-one")
    lesson.sheet("best-equivariant-of-one", mean)
    return (mean,)


@app.cell(hide_code=True)
def _(lesson, mean):
    lesson.check("best-equivariant-of-one", mean.value)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## What can go wrong

    * **A bias.** Every promise, every threshold and every weight believes the model. A reflection, a wrong antenna height, an ionosphere that did not cancel: none is in it. Look at the residuals, and at what stays for minutes.
    * **Wrong sigmas.** Too small, and all promises are too good. Too large, and you throw away what you have. Measure them: lesson 02 shows how.
    * **One threshold for all.** A ratio of 3 is too much for twenty ambiguities and too little for four.
    * **Testing until it fits.** Drop a satellite, test again, drop another: a test repeated is passed by chance.
    * **Correlated epochs.** A wrong fix seldom comes alone. Ten epochs that agree may share one reflection.
    * **Few satellites.** Where the float ellipsoid is large it holds many vectors, and one of them fits splendidly by chance. No test helps, only another satellite, a second frequency, or a length.
    * **A length that is not one.** Wood swells, poles bend, phase centres move with the direction of the signal. A hard length needs millimetres.
    * **Taken for fixed.** A best equivariant baseline is neither float nor fixed. Whoever takes it for fixed expects centimetres, and at times it is off by decimetres.

    ## Sources

    * P. J. G. Teunissen: *Success probability of integer GPS ambiguity rounding and bootstrapping*. Journal of Geodesy 72, 606–612, 1998.
    * P. J. G. Teunissen, S. Verhagen: *The GNSS ambiguity ratio-test revisited: a better way of using it*. Survey Review 41, 138–151, 2009. S. Verhagen, P. J. G. Teunissen: *The
      ratio test for future GNSS ambiguity resolution*. GPS Solutions 17, 535–548, 2013.
    * P. J. G. Teunissen, P. Joosten, C. Tiberius: *Geometry-free ambiguity success rates in case of partial fixing*. ION NTM, 1999.
    * P. J. G. Teunissen: *Theory of integer equivariant estimation with application to GNSS*. Journal of Geodesy 77, 402–410, 2003.
    * P. J. G. Teunissen, G. Giorgi, P. J. Buist: *Testing of a new single-frequency GNSS carrier phase attitude determination method: land, ship and aircraft experiments*. GPS Solutions 15, 15–28, 2011.
    * S. Verhagen, B. Li: *LAMBDA software package 3.0*, and L. Massarweh, S. Verhagen, P. J. G. Teunissen: *LAMBDA 4.0*, TU Delft, 2012 and 2024: thresholds and examples.
    * S. Wang, Y. Li, X. Sun, Y. Ji: *Dual-antenna attitude determination algorithm based on low-cost receiver*. Journal of Computer Applications 39(8), 2381–2385, 2019. Equation (16).
    * Y. Gan, L. Sui, C. Liu, M. Dong: *Instantaneous GNSS attitude by adaptive robust filtering*. Acta Geodaetica et Cartographica Sinica, 2015.
    * Real data: `matrtklib-static`, from MatRTKLIB by Taro Suzuki (MIT licence), two antennas on a roof in Nagoya, 1 Hz, and `geonet-0759-3040`, GEONET stations of the Geospatial Information Authority of Japan, 2 April 2005, from the test data of RTKLIB.
    """)
    return


if __name__ == "__main__":
    app.run()
