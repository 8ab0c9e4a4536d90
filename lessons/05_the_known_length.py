import marimo

__generated_with = "0.25.2"
app = marimo.App(width="medium", app_title="The known length", html_head_file="head.html")


@app.cell(hide_code=True)
def _():
    import marimo as mo

    from gnsslab.teaching.marimo_front import open_lesson

    lesson = open_lesson("05")
    return lesson, mo


@app.cell(hide_code=True)
def _(lesson):
    lesson.head()
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## The scene

    The roof of a car. Two receivers for 30 euros each, one antenna in front and one behind. You measured between them with a tape: **1.167 m**, good to **5 mm**.

    The filter finds where the second antenna is from the first to about a centimetre, so the heading to half a degree. Now you tell it the length as well, good to
    half a centimetre. What do you gain? And *where* do you tell it?

    A paper of 2019 put that number into its filter as one more measurement. Its heading became smooth, and the wild jumps were gone. You will build that filter, see its
    figures come out live, and find out that the length was not the reason.

    It is a long lesson, best in two sittings of three quarters of an hour. The first ends before *Where the length belongs*.
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

    The paper's campaign, simulated: two low-cost receivers, GPS and BeiDou on one frequency, 15 satellites, 650 seconds. At 300 s and at 500 s **every** satellite loses lock. The same measurements are solved in three ways, as in the paper:

    * **direct**: each second has a new baseline, only the ambiguities are carried on. No length.
    * **+ length**: a filter that knows that a baseline moves smoothly, and the length as one more measurement.
    * **+ length + (29)**: besides, the master is moved to the instant at which the rover measured.

    **The first picture** has the errors over time: heading, pitch, length, and below when a solution was not fixed. Between the two grey lines the scale is even, beyond them each step is ten times the one before: so you see millimetres and metres in one picture. **The second picture** is the baseline from above, each second a dot; the grey line is where the length is right. At rest (29) has nothing to move: the green line lies on the blue dots.
    """)
    return


@app.cell(hide_code=True)
def _(lesson, mo):
    three = lesson.lab("three-filters")
    chosen, choose = mo.state(None)
    return choose, chosen, three


@app.cell(hide_code=True)
def _(choose, lesson, prediction, three):
    lesson.wait(prediction)
    presets = three.presets(choose)
    three.preset_row(presets)
    return (presets,)


@app.cell(hide_code=True)
def _(controls, steering, three):
    result = three.run(steering.value, controls.value)
    three.view(result)
    return (result,)


@app.cell(hide_code=True)
def _(chosen, lesson, prediction, three):
    lesson.wait(prediction)
    steering = three.steering(chosen())
    return (steering,)


@app.cell(hide_code=True)
def _(chosen, steering, three):
    controls = three.controls(steering.value, chosen())
    three.panel(steering, controls)
    return (controls,)


@app.cell(hide_code=True)
def _(lesson, prediction, three):
    lesson.wait(prediction)
    saving = three.saving()
    three.saving_row(saving)
    return (saving,)


@app.cell(hide_code=True)
def _(saving, three):
    three.link(saving.value)
    return


@app.cell(hide_code=True)
def _(lesson, prediction):
    lesson.text(prediction, r"""
    **What you see.** At rest, direct jumps by tens of degrees whenever lock is lost: the ambiguities start anew, and for some seconds only the code is left. The filter does not jump. Its heading is good to 0.3°, its pitch to 0.9°, and the length
    stays within a centimetre. So far the paper is right.

    Now look for the reason. One at a time:

    1. Press **Row as printed**. Its sigma is 1.167 m in place of 5 mm, so the row does nothing. The length scatters five times as much. Heading and pitch stay as they were. **The jumps do not come back.**
    2. Press **No dynamics**. The row is there, but the filter no longer knows that the baseline moves smoothly. The jumps are back.
    3. Press **Nothing held**. Now the row and the motion are there, but the whole numbers are not written into the filter. At 300 s the heading jumps by 10°. Try other values of **Seed** (under *more*): most lose the fix for minutes.
    4. Press **Paper: turntable**. It stands for 50 s and then turns by 6° in a second. At 218 s the master's epoch is missing, and the one before must serve: **the heading** is 3° off without (29). In the paper it was the pitch.
    5. Press **Left behind**. At 20° in a second the baseline turns faster than this filter believes possible. Smooth motion is a promise, and you make it.
    6. Press **Five metres**. The millimetres stay, the angle shrinks. Then press **Heavy multipath**: with errors of 12 mm nothing is fixed, and the length cannot help.

    **And your answer?** Neither. Once the whole numbers are known, the length makes the *length* better: from 5 mm to 1 mm. Both angles stay as they were, to a few hundredths. What removed the jumps is the smooth motion and the hold.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## Why it works

    ### What the filter carries

    The filter has a *state* [$x$](/notation#x), everything that it estimates, with a covariance matrix [$P$](/notation#P). Here these are the baseline [$b$](/notation#b), its velocity [$v$](/notation#v), and one ambiguity for each satellite,
    the *single* difference $\Delta N$ of lesson 02:

    $$x = \left(b,\ v,\ \Delta N^1,\ \dots,\ \Delta N^m\right)$$

    In words: double differences go into the filter, but single differences are kept. If the reference satellite sets, nothing needs to be changed.

    **Time update.** A second passes:

    $$x \leftarrow F x, \qquad P \leftarrow F P F^\top + Q, \qquad b \leftarrow b + v\,\Delta t$$

    In words: the baseline moves on with its velocity, and the velocity may have changed a little. [$F$](/notation#F) is the *transition matrix*. The *process noise* $Q$ says how much the velocity may change: its sigma [$q_v$](/notation#q) is 2 cm/s after one second, 4 cm/s after four.
    The ambiguities have none, they stay.

    **Measurement update.** The *innovation* [$z$](/notation#z) is measured minus predicted. Its covariance is [$S$](/notation#S), and the *gain* [$K$](/notation#K) says how much of it to believe:

    $$S = H P H^\top + R, \qquad K = P H^\top S^{-1}$$

    $$x \leftarrow x + K z, \qquad P \leftarrow P - K H P$$

    In words: a sharp measurement moves the state much, a poor one little. [$H$](/notation#H) says how the measurements change with the state. [$R$](/notation#R) is the covariance of the measurements: for double differences the 4-2-2 pattern of lesson 02.

    After each update the whole numbers are searched (lesson 03). If the ratio is 3 or more, the baseline is corrected by them and given out as *fixed*. After five fixes in a row they are *held*: written into the filter as a measurement with a sigma of 0.03 cycles. From then on it is as good as certain of them.

    ### What a length does, and what it does not

    Far from a circle's centre its rim is nearly straight, and the length is nearly a straight measurement *along* the beam:

    $$z = \ell - \|b\|, \qquad H = \frac{b^\top}{\|b\|}, \qquad R = \sigma_b^2$$

    In words: [$\ell$](/notation#ell) less the length that the filter has; $H$ is the direction of the beam. So the row sees what lies along the beam, and nothing across. A sigma of 8 mm along becomes

    $$\left(\frac{1}{8^2} + \frac{1}{5^2}\right)^{-1/2} = 4.24\ \text{mm}$$

    And heading and pitch? They are what lies *across*: the heading on the level, the pitch upwards. With [$\sigma_e$](/notation#sigma_e), [$\sigma_n$](/notation#sigma_n), [$\sigma_u$](/notation#sigma_u) uncorrelated:

    $$\sigma_\psi = \frac{\sqrt{\cos^2\!\psi\,\sigma_e^2 + \sin^2\!\psi\,\sigma_n^2}}{\ell \cos\theta}$$

    $$\sigma_\theta = \frac{\sqrt{\cos^2\!\theta\,\sigma_u^2 + \sin^2\!\theta\,(\cos^2\!\psi\,\sigma_n^2 + \sin^2\!\psi\,\sigma_e^2)}}{\ell}$$

    In words: millimetres across, divided by the length. Twice the beam, half the sigma.

    There is a back door. If the errors along and across are *correlated*, what is learnt of one tells something of the other. Take a beam that points north and up by 30°, with sigmas of 9 mm north and 16 mm up. Along and across then share part of their error, and the row takes the sigma across from 14.6 mm to 13.2 mm.
    For a level beam there is hardly any such part.
    """)
    return


@app.cell(hide_code=True)
def _(lesson, prediction):
    lesson.text(prediction, r"""
    ### Does the filter know how good it is?

    A filter gives a sigma with every number. It does not look at the truth for that. It believes what you told it: the noise of the measurements, how they are correlated, how the antennas move. If that is wrong, so are the sigmas. But the filter makes a prediction every second, and then measures. The innovations tell whether it is right.

    The number to look at is the *normalised innovation squared*:

    $$\mathrm{NIS} = z^\top S^{-1} z$$

    In words: how large is the innovation, measured in sigmas of what the filter expects, squared and summed up? With [$k$](/notation#k) measurements it is [$k$](/notation#k) in the mean and its variance is $2k$, if all is well. Here $k$ is 13: for one second anything from 5 to 25 is usual. The mean of 100 seconds is ten times as sharp (question 9).

    **The first picture**, from above: the innovations of the carriers, one of them with the band that the filter expects; the NIS of carriers and codes, with its mean over the last 20 seconds; the error of the heading with the filter's two sigma; when it was fixed and held. **The second picture**: how often each NIS occurs, beside what is promised; and first fixes.
    """)
    return


@app.cell(hide_code=True)
def _(lesson, mo):
    health = lesson.lab("filter-health")
    chosen_health, choose_health = mo.state(None)
    return choose_health, chosen_health, health


@app.cell(hide_code=True)
def _(choose_health, health, lesson, prediction):
    lesson.wait(prediction)
    presets_health = health.presets(choose_health)
    health.preset_row(presets_health)
    return (presets_health,)


@app.cell(hide_code=True)
def _(controls_health, health, steering_health):
    result_health = health.run(steering_health.value, controls_health.value)
    health.view(result_health)
    return (result_health,)


@app.cell(hide_code=True)
def _(chosen_health, health, lesson, prediction):
    lesson.wait(prediction)
    steering_health = health.steering(chosen_health())
    return (steering_health,)


@app.cell(hide_code=True)
def _(chosen_health, health, steering_health):
    controls_health = health.controls(steering_health.value, chosen_health())
    health.panel(steering_health, controls_health)
    return (controls_health,)


@app.cell(hide_code=True)
def _(health, lesson, prediction):
    lesson.wait(prediction)
    saving_health = health.saving()
    health.saving_row(saving_health)
    return (saving_health,)


@app.cell(hide_code=True)
def _(health, saving_health):
    health.link(saving_health.value)
    return


@app.cell(hide_code=True)
def _(lesson, prediction):
    lesson.text(prediction, r"""
    **What you see.** The NIS of the carrier is 6 in the mean, not 13. The filter expects worse carriers than it gets: it was told 8 mm, and what is new from one second to the next is little more than 3 mm. Yet its sigma of the heading, 0.40°, is not far from the error, 0.32°. How can both be?

    Because the carrier's error is not white. Reflections make half a centimetre and last for a minute. In an innovation you see only what changed since the last second. In the heading you see all of it.

    1. Press **White noise, and told so**. Here all that the filter was told is true: NIS runs within its bounds, and 97 % of the headings lie within two sigma, where 95 % are promised.
    2. Press **Averaged, and deceived**. The filter was told that the car hardly moves, so it averages over minutes. Reflections that last do not average out. Its sigma shrinks, its error does not. And the NIS is *still* too small: what it warns of is the opposite.
    3. Press **Too sure**. The carrier is believed to 1.5 mm. NIS is seven times too large, the first fix takes two minutes, and two of three headings lie outside of two sigma.
    4. Press **RTKLIB's noise settings**. Codes are believed to 0.4 m, as for a good antenna. A test that throws out what is improbable would throw out five seconds of six, and nothing is wrong with them. **Learn the noise from the data, or say it yourself.**
    5. Press **Without the hold**. The whole numbers must be found anew each second, while reflections slowly pull the float ambiguities away. At 228 s the ratio falls below 3, long before lock is lost, and it never comes back: 23 % are fixed. Now press **Held, and wrong**. The first guess is held at once; it is wrong and stays. The hold is what makes this filter work, and what makes its mistakes last.
    6. Press **A slip nobody flags**, and see how loud the innovation says it. Press **Time to first fix**: twenty starts from cold, three ways. Half of them are fixed after 44 s with no length, after 44 s with the row, and at once with the length in the search.
    """)
    return


@app.cell(hide_code=True)
def _(lesson, prediction):
    lesson.text(prediction, r"""
    ### Where the length belongs

    There is one thing that the length can do for the angles, and it can do it only *before* the whole numbers are known: help to find them. Lesson 04 did that with one epoch. Here is a filter, on a real roof.

    Six ways to use the length: none; a **guarded row**, dropped until the baseline is known to a tenth of its length; a **row always**; an **iterated** row, linearised again where it has led to; a **second-order** row, which allows for the curvature; and the **search** of lesson 04. The seventh is our own engine, that of `gnsslab heading`.

    **The first picture** counts them all on the same epochs. **The second picture** follows the one that you choose: was it fixed, was its row used, how long is its baseline, and how far off.
    """)
    return


@app.cell(hide_code=True)
def _(lesson, mo):
    forms = lesson.lab("length-forms")
    chosen_forms, choose_forms = mo.state(None)
    return choose_forms, chosen_forms, forms


@app.cell(hide_code=True)
def _(choose_forms, forms, lesson, prediction):
    lesson.wait(prediction)
    presets_forms = forms.presets(choose_forms)
    forms.preset_row(presets_forms)
    return (presets_forms,)


@app.cell(hide_code=True)
def _(controls_forms, forms, steering_forms):
    result_forms = forms.run(steering_forms.value, controls_forms.value)
    forms.view(result_forms)
    return (result_forms,)


@app.cell(hide_code=True)
def _(chosen_forms, forms, lesson, prediction):
    lesson.wait(prediction)
    steering_forms = forms.steering(chosen_forms())
    return (steering_forms,)


@app.cell(hide_code=True)
def _(chosen_forms, forms, steering_forms):
    controls_forms = forms.controls(steering_forms.value, chosen_forms())
    forms.panel(steering_forms, controls_forms)
    return (controls_forms,)


@app.cell(hide_code=True)
def _(forms, lesson, prediction):
    lesson.wait(prediction)
    saving_forms = forms.saving()
    forms.saving_row(saving_forms)
    return (saving_forms,)


@app.cell(hide_code=True)
def _(forms, saving_forms):
    forms.link(saving_forms.value)
    return


@app.cell(hide_code=True)
def _(lesson, prediction):
    lesson.text(prediction, r"""
    **What you see.** Eight satellites, one frequency. With no length two thirds of the epochs are fixed. With the guarded row **not one**. The row was let in once the baseline was known to 10 cm. By then it pointed 40 cm to the side of the truth, and the row made the length right there. A filter that has the right length at a wrong place has no reason to move.

    1. Set **Shown over time** to *search*: all epochs, from the first second on.
    2. Press **Row at every epoch**. Nine satellites would be enough without a length. With the row, none is fixed.
    3. Press **Iterated**, and move **Satellites** from 6 to 5 and to 7. Then press **Second order**. Each is sometimes splendid and sometimes a disaster.
    4. Press **Each epoch alone**. The codes of one epoch never pass the guard: it drops the row just where a length would help most. RTKLIB does that without a word.
    5. Press **2 cm wrong**, then **10 cm wrong**. A wrong length hurts. In single epochs the search refuses. In a filter the guarded row fixes three of four epochs *wrong*, and holds them.
    6. Press **Multipath**: our engine, which knows that reflections last, keeps its fixes; the filter of the paper loses some.
    7. Press **The paper's receivers**. Fifteen satellites are sure of the baseline when the guard opens: the row does no harm, and no good.

    **So the length belongs into the search.** That is what `gnsslab heading --length` does. A row is right afterwards, when the whole numbers are known: then the baseline is known to millimetres, and the circle is straight.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ### The equations of a crooked row

    $\|b\|$ is no straight function of $b$. If $b$ is uncertain across the beam by [$\sigma$](/notation#sigma), two things go wrong.

    **A bias.** Whatever lies across makes the baseline *longer*, on whichever side it lies: by $\sigma^2 / 2\ell$ for each of the two directions. With 40 cm and a beam of 1 m that is 8 cm for each. No sigma knows of it. The second-order row takes that mean off and adds its variance:

    $$z = \ell - \|b\| - \frac{\operatorname{tr}(MP)}{2\,\|b\|}, \qquad S = H P H^\top + \sigma_b^2 + \frac{\operatorname{tr}(MPMP)}{2\,\|b\|^2}$$

    with the part across, $M = I - H^\top H$. In words: the more uncertain the direction, the less a length says.

    **A wrong direction.** The row works along $H$, and $H$ points where the baseline *seems* to point. If that is 20° off, the filter is told 5 mm about a direction that is not the beam's, and it believes it. Iterating finds a better point to linearise at, but still one point. The ellipsoid of the float baseline covers half the sphere.

    **The search** has none of that. For each vector of whole numbers the baseline is known to millimetres, so it knows its own direction:

    $$\|\hat a - a\|^2_{Q_a} + \min_{\|b\| = \ell} \|\hat b(a) - b\|^2_{Q_{b|a}}$$

    In words, as in lesson 04: fit the float ambiguities *and* have the right length. Inside a filter, $\hat a$ and [$Q_a$](/notation#Q_a) are those of the state, and the length is used nowhere else, so it is used once.
    """)
    return


@app.cell(hide_code=True)
def _(lesson, prediction):
    lesson.text(prediction, r"""
    ### On the move

    Two receivers, two clocks. Each measures when *its* clock says that the second is full. If one is late by [$\Delta t$](/notation#Delta) and the car drives at [$v$](/notation#v), the master has moved on by $v\,\Delta t$ when the rover measures.

    **The first picture** has the errors of heading and pitch, and the heading rate; **the second** has the way. All satellites of GPS and Galileo on one frequency, the length in the search.
    """)
    return


@app.cell(hide_code=True)
def _(lesson, mo):
    platforms = lesson.lab("platforms")
    chosen_platforms, choose_platforms = mo.state(None)
    return choose_platforms, chosen_platforms, platforms


@app.cell(hide_code=True)
def _(choose_platforms, lesson, platforms, prediction):
    lesson.wait(prediction)
    presets_platforms = platforms.presets(choose_platforms)
    platforms.preset_row(presets_platforms)
    return (presets_platforms,)


@app.cell(hide_code=True)
def _(controls_platforms, platforms, steering_platforms):
    result_platforms = platforms.run(steering_platforms.value, controls_platforms.value)
    platforms.view(result_platforms)
    return (result_platforms,)


@app.cell(hide_code=True)
def _(chosen_platforms, lesson, platforms, prediction):
    lesson.wait(prediction)
    steering_platforms = platforms.steering(chosen_platforms())
    return (steering_platforms,)


@app.cell(hide_code=True)
def _(chosen_platforms, platforms, steering_platforms):
    controls_platforms = platforms.controls(steering_platforms.value, chosen_platforms())
    platforms.panel(steering_platforms, controls_platforms)
    return (controls_platforms,)


@app.cell(hide_code=True)
def _(lesson, platforms, prediction):
    lesson.wait(prediction)
    saving_platforms = platforms.saving()
    platforms.saving_row(saving_platforms)
    return (saving_platforms,)


@app.cell(hide_code=True)
def _(platforms, saving_platforms):
    platforms.link(saving_platforms.value)
    return


@app.cell(hide_code=True)
def _(lesson, prediction):
    lesson.text(prediction, r"""
    **What you see.** A car on a road like an eight. The heading is good to 0.3°, the pitch to 0.5°, and it turns by up to 13° in a second. No measurement of the turn is needed: heading comes from where the antennas are, not from how they got there.

    1. Press **50 ms apart, across**. The antennas stand across the roof, and the car drives 75 cm in that time. All seconds are fixed, *all with the right whole numbers for a baseline that never was*, and the heading is tens of degrees off. Switch **Correct the master's position (29)** on.
    2. Press **50 ms apart, along**. Now the error goes into the length, and the heading hardly notices.
    3. Press **50 ms apart, length known**. No vector has the right length, so nothing is fixed. A known length is also a guard.
    4. Press **A second apart, corrected**. The velocity comes from the Dopplers and is good to some centimetres a second. A second of it makes centimetres, and degrees: three of four seconds are more than 5 cm off and so count as wrong. A correction is as good as its velocity.
    5. Press **30 cm**: three times the error, as the beam is three times shorter.
    6. Press **Between houses**: 58 % of the seconds are fixed, none wrong. Then **Between houses, GPS alone**, without the length: 8 %, and most of these are wrong.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ### The equations of a late receiver

    The master is moved to the rover's instant by its own velocity [$v_m$](/notation#v); this is equation (29) of the paper:

    $$b = b_{\text{measured}} - v_m\,\Delta t$$

    In words: until the rover measured, the master went on by $v_m\,\Delta t$. That is motion, not baseline. Without the correction, with the motion across the beam, the heading is off by

    $$\arctan\frac{v\,\Delta t}{\ell}$$

    With 15 m/s and 1 ms that is 1.5 cm, and **0.74°** on a beam of 1.167 m. Clocks of cheap receivers drift by as much within minutes if they are not steered. A turntable hides it: at 6 cm/s a millisecond is 0.06 mm.

    What the correction costs: the sigma of the velocity times $\Delta t$. A millisecond costs nothing. A whole second, with Dopplers of 5 cm/s, costs some 9 cm of height and so **five degrees of pitch**.

    **Heading rate** $\dot\psi$ is the difference of two headings over the time between them. Reflections that last for a minute are the same in both and cancel, so the rate is better than the sigmas of the headings suggest.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## The same in a few lines

    Copy this: the paper's campaign, and its filter three times.

    ```python
    from dataclasses import replace
    import numpy as np
    from gnsslab.gnss.preparation import prepare_moving
    from gnsslab.simulate import find_preset, simulate
    from gnsslab.systems.constrained_filter import run_filter, steady_path
    from gnsslab.systems.dual_antenna import A_STATIC as system
    from gnsslab.systems.length_row import LengthUse

    sim = simulate(find_preset(system.preset), np.random.default_rng(3))
    prepared = prepare_moving(*sim.observations, sim.ephemerides, system.settings)
    path = steady_path(prepared, system.velocity_noise)
    uses = (LengthUse.NOWHERE, LengthUse.GUARDED_ROW, LengthUse.SEARCH)
    runs = [run_filter(prepared, path, replace(system.filter, length_use=use)) for use in uses]
    print([run.first_fix for run in runs])
    print([round(float(np.linalg.norm(run.baseline[500:], axis=1).std()), 4) for run in runs])  # [m]
    ```

    The first fix comes at second 73 with no length and with the row, and at second 16 with the search. The length scatters by 5 mm without it and by 1 mm with it.

    For your own files one call does it all, with the length in the search. Here on a simulated car:

    ```python
    import numpy as np
    import gnsslab as gl
    from gnsslab.simulate import find_preset, simulate

    sim = simulate(find_preset("car-heading"), np.random.default_rng(1))  # yours: gl.read_rinex_obs, gl.read_rinex_nav
    pose = gl.dual_antenna_attitude(*sim.observations, sim.ephemerides, length=1.0, systems="GE", frequencies=1)
    print(pose)
    print(np.degrees(gl.heading_rate(pose).rate[1:4]).round(1))
    ```
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## Reach a goal

    Two for each lab. They are judged as you move. Some controls that help are under *more*.
    """)
    return


@app.cell(hide_code=True)
def _(result, three):
    three.goal("sharp", result)
    return


@app.cell(hide_code=True)
def _(result, three):
    three.goal("lag", result)
    return


@app.cell(hide_code=True)
def _(health, result_health):
    health.goal("health-band", result_health)
    return


@app.cell(hide_code=True)
def _(health, result_health):
    health.goal("health-both", result_health)
    return


@app.cell(hide_code=True)
def _(forms, result_forms):
    forms.goal("five-alone", result_forms)
    return


@app.cell(hide_code=True)
def _(forms, result_forms):
    forms.goal("do-harm", result_forms)
    return


@app.cell(hide_code=True)
def _(platforms, result_platforms):
    platforms.goal("short-arm", result_platforms)
    return


@app.cell(hide_code=True)
def _(platforms, result_platforms):
    platforms.goal("half-a-second", result_platforms)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## Real data

    The roof in Nagoya again: `matrtklib-static`, 301 seconds, GPS on one frequency, the highest satellites that are left. The table has what the third lab counts: **fixed and right**, and fixed and wrong where there are any.
    *Direct* and *+ length* are the paper's first two modes; the third is the same as the second, as nothing moves. C-LAMBDA is the search, in the same filter, or for each epoch alone.

    | satellites left | direct | + length | C-LAMBDA in the filter | each epoch alone, no length | alone, C-LAMBDA |
    |:---|---|---|---|---|---|
    | 9 | 100 % | 100 % | 100 % | 99.3 % | 100 % |
    | 8 | 66.8 % | **0 %** | 100 % | 66.4 % | 100 % |
    | 7 | 71.4 % | 71.4 % | 100 % | 69.8 % | 100 % |
    | 6 | 74.4 % | 74.4 % | 100 % | 44.5 % | 93.0 % |
    | 5 | 47.8 % | 47.8 % | 100 % | 5.0 %, wrong 6.6 % | 82.4 % |

    Look at the column *+ length*. With nine satellites it is as good as the search, and with eight it fixes nothing. With seven, six and five it changes nothing at all: the guard never opens, or opens too late. The search fixes all epochs, at once and every time.

    Why so late? The filter was told 30 cm for the code, and these codes are three times better. Set **Assumed noise** in the third lab to *learnt from the codes*. Now the guard opens sooner, and with **six satellites** 90 % of the epochs are fixed *wrong*. A row is not made safe by better sigmas. The search does not mind: 100 % with each setting of the noise.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## Reproduce

    The paper's numbers beside ours. Ours are medians of 20 simulated campaigns, at 218 s with their standard deviation. At rest seconds 100 to 649 count. `gnsslab reproduce A -o paper-a.html` makes them anew, with all the rest.

    | what | paper | ours | verdict |
    |:---|---|---|---|
    | heading at rest, + length | 0.5° | 0.35° rms, 0.97° at most | near: between the two |
    | pitch at rest, + length | 2 to 3° | 0.87° rms, 2.5° at most | holds for the largest error |
    | length at rest, + length | 1.16 to 1.17 m | 1.163 to 1.171 m | holds |
    | half the band of the length becomes narrower by | 1 cm | 1.1 cm | holds |
    | heading after 300 s and 500 s, direct | gross errors | 34°, 34° | holds |
    | the same, + length | gone | 0.55°, 0.55° | holds |
    | the same, the row as printed in (16) | not tried | 0.56°, 0.54° | so it is not the row |
    | turntable after 150 s, direct and + length | gross error, gone | 49°, 0.6° | holds |
    | turntable at 218 s, + length, heading and pitch | the pitch jumps | −2.8° ± 0.3°, 0.1° ± 0.7° | does not hold |
    | the same with (29) | gone | −0.2° ± 2.0°, 1.0° ± 4.7° | in the mean; the pitch gets worse |
    | first fix at rest, + length | 30 to 40 s | 26 s, from 0 to 166 s | holds |
    | length in the search: heading at rest, first fix | not tried | 0.33° rms, 0 s | better |

    **What holds.** The paper does not say what its accuracy is. Two or three degrees of pitch is our *largest* error; half a degree of heading lies between our rms and our largest. The length stays within a centimetre.

    **What does not hold.**

    * *The length removes the gross errors.* It does not. With the row as printed, which does nothing, they are removed just as well. The motion model and the hold do it.
    * *The pitch was off at second 218, by the clocks.* A master that moves on the level displaces the baseline on the level. So the *heading* jumps, by $\arctan(v\,\Delta t/\ell)$. And a clock offset of milliseconds moves a turntable by less than a tenth of a millimetre. A missing epoch of the master explains the size.
    * *The correction (29) removes it.* In the mean it does: −2.8° becomes −0.2°. But with Dopplers of 5 cm/s a single run is left with 2° of heading and 5° of *pitch*. Press **A bad velocity** in the first lab: the correction makes 5° out of 3°. With good velocities it does what it says.

    **Better than the paper.** One run of the twenty waited 166 s for its first fix, and until then its heading was off by up to 25°. With the length in the search most runs are fixed in the first second, and in none is the heading off by more than 1.5° after second 100.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## Find the printed error

    Set **Formula as printed** in the first lab, one after the other, or press the buttons named here.

    | equation | printed | right | what it does |
    |:---|:---|:---|:---|
    | (6) pitch | $\arcsin\frac{u}{h}$ | $\arctan\frac{u}{h}$ | 30° becomes **35.3°**; above 45° there is no answer. Press **Printed pitch** |
    | (16) length row | $R = \ell^2$ | $R = \sigma_b^2$ | the row does nothing: 8 mm along the beam stay 8.00 mm, not 4.24 mm. **Row as printed** |
    | (25) prediction | $F P + Q$ | $F P F^\top + Q$ | $P$ is no covariance any more and does not grow: the filter is sure to 0.02°. On the turntable it is off by half a turn. **Printed prediction** |
    | (30), (31) residual | without the range | less the geometric range | the filter cannot find its baseline: the heading turns round and round. **Printed residual** |
    | (33) heading sigma | a square is missing, times $\cos\theta$ | as above | 7.6 times too large, and another number in other units. **Printed sigma** |
    | (34) pitch sigma | a cosine is missing, east and north exchanged | as above | 1 % too large, so nobody notices |

    The numbers of the last two lines are for a beam of 1.167 m at a heading of 50° and a pitch of 25°, with sigmas of 6, 9 and 16 mm.

    **The one that did no harm.** Equation (16) is off by a factor of 233 in sigma, and all of the paper's figures look well. An error that does nothing is hard to find: everything works, but for another reason than you think.

    **The one that looks like progress.** With (25) as printed the heading at rest is *better*, 0.16° in place of 0.26°. The filter has stopped listening, and as nothing moves it is right. Press **Paper: turntable**, set (25) again, and look. Try what you believe where it can fail.
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
    printed_pitch = lesson.ask("a-steep-pitch-as-printed")
    lesson.sheet("a-steep-pitch-as-printed", printed_pitch)
    return (printed_pitch,)


@app.cell(hide_code=True)
def _(lesson, printed_pitch):
    lesson.check("a-steep-pitch-as-printed", printed_pitch.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    heading_sigma = lesson.ask("sigma-of-a-steep-heading")
    lesson.sheet("sigma-of-a-steep-heading", heading_sigma)
    return (heading_sigma,)


@app.cell(hide_code=True)
def _(heading_sigma, lesson):
    lesson.check("sigma-of-a-steep-heading", heading_sigma.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    pitch_sigma = lesson.ask("sigma-of-a-steep-pitch")
    lesson.sheet("sigma-of-a-steep-pitch", pitch_sigma)
    return (pitch_sigma,)


@app.cell(hide_code=True)
def _(lesson, pitch_sigma):
    lesson.check("sigma-of-a-steep-pitch", pitch_sigma.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    late = lesson.ask("a-late-receiver")
    lesson.sheet("a-late-receiver", late)
    return (late,)


@app.cell(hide_code=True)
def _(late, lesson):
    lesson.check("a-late-receiver", late.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    speed = lesson.ask("least-speed")
    lesson.sheet("least-speed", speed)
    return (speed,)


@app.cell(hide_code=True)
def _(lesson, speed):
    lesson.check("least-speed", speed.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    tape = lesson.ask("tape-and-prior")
    lesson.sheet("tape-and-prior", tape)
    return (tape,)


@app.cell(hide_code=True)
def _(lesson, tape):
    lesson.check("tape-and-prior", tape.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    printed_row = lesson.ask("the-row-as-printed")
    lesson.sheet("the-row-as-printed", printed_row)
    return (printed_row,)


@app.cell(hide_code=True)
def _(lesson, printed_row):
    lesson.check("the-row-as-printed", printed_row.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    beam = lesson.ask("a-shorter-beam")
    lesson.sheet("a-shorter-beam", beam)
    return (beam,)


@app.cell(hide_code=True)
def _(beam, lesson):
    lesson.check("a-shorter-beam", beam.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    bound = lesson.ask("bound-of-the-mean")
    lesson.sheet("bound-of-the-mean", bound)
    return (bound,)


@app.cell(hide_code=True)
def _(bound, lesson):
    lesson.check("bound-of-the-mean", bound.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    mean = lesson.ask("what-the-mean-says")
    lesson.sheet("what-the-mean-says", mean)
    return (mean,)


@app.cell(hide_code=True)
def _(lesson, mean):
    lesson.check("what-the-mean-says", mean.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    ratio = lesson.ask("ratio-with-the-length")
    lesson.sheet("ratio-with-the-length", ratio)
    return (ratio,)


@app.cell(hide_code=True)
def _(lesson, ratio):
    lesson.check("ratio-with-the-length", ratio.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    rate = lesson.ask("heading-rate")
    lesson.sheet("heading-rate", rate)
    return (rate,)


@app.cell(hide_code=True)
def _(lesson, rate):
    lesson.check("heading-rate", rate.value)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## What can go wrong

    * **A length that is not the one.** It goes from phase centre to phase centre, not from housing to housing. Five centimetres off, and no single epoch is fixed. Ten too short, and even the search in a filter fixes all epochs wrong.
    * **A row too early.** It makes the length right at a wrong place, and the filter sure of it. Look at the fix rate with and without the length. It must never fall.
    * **The hold.** It carries right whole numbers over gaps, and wrong ones as well. Let it wait, and let the innovations speak: a hold that is wrong shows in the NIS at once.
    * **Noise settings of another receiver.** Too small, and good measurements are thrown out. Too large, and nothing is fixed. Learn them from the data.
    * **White noise that is not white.** A filter that averages reflections is sure of the wrong thing. NIS will not tell you.
    * **Two clocks.** At rest you never see them. Test a heading while you drive.
    * **Antennas across the roof.** They give a fine roll and a fine heading, and a heading that suffers from every millisecond. Along the roof the millisecond goes into the length.
    * **A correct figure for a wrong reason.** Switch things off, one at a time.

    ## Sources

    * S. Wang, Y. Li, X. Sun, Y. Ji: *Dual-antenna attitude determination algorithm based on low-cost receiver*. Journal of Computer Applications 39(8), 2381–2385, 2019.
    * P. J. G. Teunissen, G. Giorgi, P. J. Buist: *Testing of a new single-frequency GNSS carrier phase attitude determination method: land, ship and aircraft experiments*. GPS Solutions 15, 15–28, 2011.
    * Y. Bar-Shalom, X. R. Li, T. Kirubarajan: *Estimation with Applications to Tracking and Navigation*. Wiley, 2001: innovations, NIS, iterated and second-order filters.
    * T. Takasu: *RTKLIB 2.4.2 manual*, 2013: moving base, baseline length constraint, fix and hold.
    * Real data: `matrtklib-static`, from MatRTKLIB by Taro Suzuki (MIT licence), two antennas on a roof in Nagoya, 1 Hz.
    """)
    return


if __name__ == "__main__":
    app.run()
