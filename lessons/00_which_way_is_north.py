import marimo

__generated_with = "0.25.2"
app = marimo.App(width="medium", app_title="Which way is north?", html_head_file="head.html")


@app.cell(hide_code=True)
def _():
    import marimo as mo

    from gnsslab.teaching.marimo_front import open_lesson

    lesson = open_lesson("00")
    return lesson, mo


@app.cell(hide_code=True)
def _(lesson):
    lesson.head()
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## The scene

    You stand on a flat roof. Two small satellite antennas are bolted to a beam, **1.2 m** apart. Each has its own
    receiver. Your task: say which way the beam points.

    A phone's compass would be off by 5 to 10 degrees here, because the roof is full of steel. Satellites do not care
    about steel. But each receiver alone only knows where it stands to about **2 m**, and the beam is shorter than that.
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

    Each dot is one second of measurements from both receivers, at the start each solved on its own. The picture on the right is the roof
    seen from above: the black square is the first antenna, the arrow points to the second.
    """)
    return


@app.cell(hide_code=True)
def _(lesson, mo):
    north = lesson.lab("north")
    chosen, choose = mo.state(None)
    return choose, chosen, north


@app.cell(hide_code=True)
def _(choose, lesson, north, prediction):
    lesson.wait(prediction)
    presets = north.presets(choose)
    north.preset_row(presets)
    return (presets,)


@app.cell(hide_code=True)
def _(controls, north, steering):
    result = north.run(steering.value, controls.value)
    north.view(result)
    return (result,)


@app.cell(hide_code=True)
def _(chosen, lesson, north, prediction):
    lesson.wait(prediction)
    steering = north.steering(chosen())
    return (steering,)


@app.cell(hide_code=True)
def _(chosen, north, steering):
    controls = north.controls(steering.value, chosen())
    north.panel(steering, controls)
    return (controls,)


@app.cell(hide_code=True)
def _(lesson, north, prediction):
    lesson.wait(prediction)
    saving = north.saving()
    north.saving_row(saving)
    return (saving,)


@app.cell(hide_code=True)
def _(north, saving):
    north.link(saving.value)
    return


@app.cell(hide_code=True)
def _(lesson, prediction):
    lesson.text(prediction, r"""
    **What you see.** Blue circles are *fixed*: the receiver-to-satellite distances were counted in whole wavelengths of
    19 or 24 cm, and every whole number was found. Orange triangles are *float*: the whole numbers were not found, and only
    the coarse code measurement is left. The coarse one misses by metres. The fixed one misses by millimetres.

    Try these, one at a time:

    1. Move **Baseline length** from 0.3 m to 5 m. The millimetres stay, the degrees shrink.
    2. Move **Carrier noise**. Twice the noise, twice the scatter; and at some point the integers get lost.
    3. Add **Systems** or **Frequencies**. More distances to the same three coordinates: the triangles go.
    4. Raise the **Elevation mask**. You throw satellites away, and the triangles come back.
    5. Switch **Each second alone** off. Now a filter remembers the whole numbers, and one good second serves the next.

    **And your answer?** One second is enough for a few tenths of a degree, but only where the whole numbers are found. Where
    they are not, that second tells nothing: its error is longer than the beam. Both are true at once, and the colours tell
    you which second is which.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## Why it works

    The line from the first antenna to the second is the **baseline** $b$. Write it as metres east $e$, north $n$ and
    up $u$. Heading $\psi$ turns clockwise from north. Pitch $\theta$ is positive upwards.

    $$\psi = \operatorname{atan2}(e,\ n)$$

    $$\theta = \operatorname{atan2}(u,\ h), \qquad h = \sqrt{e^2+n^2}$$

    In words: heading is the angle whose opposite side is east and whose adjacent side is north. Pitch is the angle
    between the baseline and its shadow on the ground. A $\operatorname{atan2}$ looks at both signs, so it knows all four
    quadrants.

    An error of a few millimetres across the baseline turns it by a small angle. With standard deviations $\sigma_e$,
    $\sigma_n$, $\sigma_u$, covariance $\sigma_{en}$ and length $\ell$:

    $$\sigma_\psi = \frac{\sqrt{\cos^2\!\psi\,\sigma_e^2 + \sin^2\!\psi\,\sigma_n^2 - \sin 2\psi\,\sigma_{en}}}{\ell\cos\theta}$$

    $$\sigma_\theta = \frac{\sqrt{\cos^2\!\theta\,\sigma_u^2 + \sin^2\!\theta\,\sigma_h^2 - \sin 2\theta\,\sigma_{hu}}}{\ell}$$

    Here $\sigma_h$ belongs to the level distance $h$, so $\sigma_h^2 = \cos^2\!\psi\,\sigma_n^2 + \sin^2\!\psi\,\sigma_e^2 + \sin 2\psi\,\sigma_{en}$.

    In words: only the error *across* the baseline counts, and it counts less on a longer lever. Pitch is worse than
    heading, because satellites are all above you and none below: up is the weakest direction.

    **Where do the millimetres come from?** A receiver can read the phase of the carrier wave to about 1 % of its
    19 cm. What it cannot see is how many whole waves lie between it and the satellite. That number is an *integer*,
    and an integer can be found exactly.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## The same in six lines

    Copy this. It reads two observation files and one file of orbits, and does what the lab does at its start.

    ```python
    import gnsslab as gl

    master, rover = gl.read_rinex_obs("master.obs"), gl.read_rinex_obs("rover.obs")
    orbits = gl.read_rinex_nav("broadcast.nav")
    pose = gl.dual_antenna_attitude(master, rover, orbits, systems="G", single_epoch=True)
    print(pose)
    gl.plot_attitude(pose).savefig("heading.png")
    ```

    No files at hand? `gnsslab simulate static-baseline -o roof` writes some, of a beam of 1.167 m.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## Reach a goal

    Move the controls above until both goals are reached. They are judged as you move.
    """)
    return


@app.cell(hide_code=True)
def _(north, result):
    north.goal("sharp", result)
    return


@app.cell(hide_code=True)
def _(north, result):
    north.goal("frugal", result)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## Real data

    Set **Data** to *real roof*. Two survey receivers stood 0.99 m apart on a roof in Japan on 24 June 2024, for
    five minutes. The arrow turns to **193 degrees**, a little west of south. Nobody simulated this.

    Compare with the simulation:

    * The scatter is smaller, because survey antennas have a carrier noise of about 1 mm.
    * It is not white. Look for slow waves: signals bounced off the roof (*multipath*) change over minutes.
    * Noise and length are now facts, not controls. They are greyed out.

    Set **Data** to *my files* to use your own: two observation files of the same time and one of broadcast orbits.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## Find the printed error

    This lesson follows a paper of 2019 on low-cost receivers. Some of its formulas went wrong in print. The engine uses the
    corrected ones. Here you can switch between them.

    | | as printed | corrected |
    |---|---|---|
    | heading (5) | $\arctan(e/n)$ | $\operatorname{atan2}(e, n)$ |
    | pitch (6) | $\arcsin(u/h)$ | $\operatorname{atan2}(u, h)$ |

    The sigmas (33) of heading and (34) of pitch went wrong too. Look for them in the lab; the formulas stand below it.

    In the first picture you see the error of the formula at all headings and at all pitches. The second shows 2000 beams
    drawn with the errors you set. Two thirds of them should lie within the dashed lines: that is what a sigma promises.
    """)
    return


@app.cell(hide_code=True)
def _(lesson, mo):
    printed = lesson.lab("printed")
    chosen_print, choose_print = mo.state(None)
    return choose_print, chosen_print, printed


@app.cell(hide_code=True)
def _(choose_print, printed):
    presets_print = printed.presets(choose_print)
    printed.preset_row(presets_print)
    return (presets_print,)


@app.cell(hide_code=True)
def _(controls_print, printed, steering_print):
    result_print = printed.run(steering_print.value, controls_print.value)
    printed.view(result_print)
    return (result_print,)


@app.cell(hide_code=True)
def _(chosen_print, printed):
    steering_print = printed.steering(chosen_print())
    return (steering_print,)


@app.cell(hide_code=True)
def _(chosen_print, printed, steering_print):
    controls_print = printed.controls(steering_print.value, chosen_print())
    printed.panel(steering_print, controls_print)
    return (controls_print,)


@app.cell(hide_code=True)
def _(printed):
    saving_print = printed.saving()
    printed.saving_row(saving_print)
    return (saving_print,)


@app.cell(hide_code=True)
def _(printed, saving_print):
    printed.link(saving_print.value)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    **(33) forgets a square.** As printed:

    $$\sigma_\psi = \frac{\sqrt{\cos^2\psi\,\sigma_e^2 + \sin^2\psi\,\sigma_n}}{\ell}\cos\theta$$

    Corrected:

    $$\sigma_\psi = \frac{\sqrt{\cos^2\psi\,\sigma_e^2 + \sin^2\psi\,\sigma_n^2}}{\ell\cos\theta}$$

    Take $\sigma_e = 6$ mm, $\sigma_n = 9$ mm and $\sigma_u = 16$ mm on $\ell = 1.167$ m, with $\psi = 50°$ and $\theta = 25°$. The
    print gives 3.24° for heading. Corrected it is 0.43°, and drawn beams confirm that. Put millimetres into the same print
    instead of metres, and it gives 0.20°. A formula whose answer depends on the unit is wrong.

    **(34) swaps east and north, and loses a $\cos^2\psi$.** As printed:

    $$\sigma_\theta = \frac{\sqrt{\cos^2\theta\,\sigma_u^2 + \sin^2\theta\,(\sigma_e^2 + \sin^2\psi\,\sigma_n^2)}}{\ell}$$

    Corrected:

    $$\sigma_\theta = \frac{\sqrt{\cos^2\theta\,\sigma_u^2 + \sin^2\theta\,(\sin^2\psi\,\sigma_e^2 + \cos^2\psi\,\sigma_n^2)}}{\ell}$$

    For the same beam it gives 0.74° instead of 0.73°: so small that nobody sees it.

    **Why did nobody notice (5) and (6)?** The paper measured northward and on level ground. At 2° of pitch the misprint in (6) is
    a thousandth of a degree. So small an error can hide. In this goal you hide it once more:
    """)
    return


@app.cell(hide_code=True)
def _(printed, result_print):
    printed.goal("unnoticed", result_print)
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
    beam = lesson.ask("heading-of-a-beam")
    lesson.sheet("heading-of-a-beam", beam)
    return (beam,)


@app.cell(hide_code=True)
def _(beam, lesson):
    lesson.check("heading-of-a-beam", beam.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    sharpness = lesson.ask("sigma-of-heading")
    lesson.sheet("sigma-of-heading", sharpness)
    return (sharpness,)


@app.cell(hide_code=True)
def _(lesson, sharpness):
    lesson.check("sigma-of-heading", sharpness.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    lever = lesson.ask("length-for-a-sigma")
    lesson.sheet("length-for-a-sigma", lever)
    return (lever,)


@app.cell(hide_code=True)
def _(lesson, lever):
    lesson.check("length-for-a-sigma", lever.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    swapped = lesson.ask("swapped-cables")
    lesson.sheet("swapped-cables", swapped)
    return (swapped,)


@app.cell(hide_code=True)
def _(lesson, swapped):
    lesson.check("swapped-cables", swapped.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    tilted = lesson.ask("sigma-of-a-tilted-beam")
    lesson.sheet("sigma-of-a-tilted-beam", tilted)
    return (tilted,)


@app.cell(hide_code=True)
def _(lesson, tilted):
    lesson.check("sigma-of-a-tilted-beam", tilted.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    printed_pitch = lesson.ask("pitch-as-printed")
    lesson.sheet("pitch-as-printed", printed_pitch)
    return (printed_pitch,)


@app.cell(hide_code=True)
def _(lesson, printed_pitch):
    lesson.check("pitch-as-printed", printed_pitch.value)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## What can go wrong

    * **A wrong fix.** The whole numbers are wrong, the sigma is small, and the heading is off by many degrees. A known
      length catches most of them.
    * **Multipath.** A wall beside the antenna shifts the phase by up to 5 cm, slowly. No averaging over a minute removes it.
    * **Magnetic or true north?** Satellites give true north. A compass differs by the local declination, up to 20 degrees.
    * **A steep beam.** With the beam upright there is no heading: $e$ and $n$ are nearly zero.
    * **Twisted antennas.** The electrical centre of a cheap antenna lies some millimetres off its axis. Mount both the same way round.
    * **Roll.** Two antennas give two of three angles. Turn the beam about itself: nothing changes. A third antenna would tell.

    ## Sources

    * S. Wang, Y. Li, X. Sun, Y. Ji: *Dual-antenna attitude determination algorithm based on low-cost receiver*. Journal of
      Computer Applications 39(8), 2381–2385, 2019.
    * Real data: `matrtklib-static` from MatRTKLIB by Taro Suzuki (MIT licence), two Septentrio mosaic-X5, 301 s at 1 Hz.
    * RINEX: the format of the files, IGS and RTCM, version 3.04, 2018.
    """)
    return


if __name__ == "__main__":
    app.run()
