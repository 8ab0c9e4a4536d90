import marimo

__generated_with = "0.25.2"
app = marimo.App(width="medium", app_title="Why integers make centimetres", html_head_file="head.html")


@app.cell(hide_code=True)
def _():
    import marimo as mo

    from gnsslab.teaching.marimo_front import open_lesson

    lesson = open_lesson("03")
    return lesson, mo


@app.cell(hide_code=True)
def _(lesson):
    lesson.head()
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## The scene

    A pole with an antenna stands on a mark, whose place is known. A second receiver stands a few hundred metres away. They measure once, for an
    instant: six satellites on two frequencies.

    The receiver on the pole shows where it is: **75 cm** beside the mark. It computes for less than a millisecond, and shows another position:
    **7 mm** beside the mark.

    Nothing was measured in between. It has found ten whole numbers.
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

    The picture is a map about the mark. Every blue dot is one *epoch*, that is one instant: a position from codes and carriers, in which the unknown
    whole numbers of the carriers may take any value, fractions too. This is the *float solution*.

    Then the whole numbers are searched for, and the same epoch gives a second position, the *fixed solution*. With the right integers it lies
    in the green dot in the middle, and the little window magnifies that dot. With wrong integers it is an orange cross. Each ellipse holds 95 % of
    its dots, if the noise is what the solver believes.

    The second picture counts how often all integers are right at once: the green dot. The curve is what the solver promises before it has seen a
    measurement, for one epoch or for the mean of several.
    """)
    return


@app.cell(hide_code=True)
def _(lesson, mo):
    centimetres = lesson.lab("centimetres")
    chosen, choose = mo.state(None)
    return centimetres, choose, chosen


@app.cell(hide_code=True)
def _(centimetres, choose, lesson, prediction):
    lesson.wait(prediction)
    presets = centimetres.presets(choose)
    centimetres.preset_row(presets)
    return (presets,)


@app.cell(hide_code=True)
def _(centimetres, controls, steering):
    result = centimetres.run(steering.value, controls.value)
    centimetres.view(result)
    return (result,)


@app.cell(hide_code=True)
def _(centimetres, chosen, lesson, prediction):
    lesson.wait(prediction)
    steering = centimetres.steering(chosen())
    return (steering,)


@app.cell(hide_code=True)
def _(centimetres, chosen, steering):
    controls = centimetres.controls(steering.value, chosen())
    centimetres.panel(steering, controls)
    return (controls,)


@app.cell(hide_code=True)
def _(centimetres, lesson, prediction):
    lesson.wait(prediction)
    saving = centimetres.saving()
    centimetres.saving_row(saving)
    return (saving,)


@app.cell(hide_code=True)
def _(centimetres, saving):
    centimetres.link(saving.value)
    return


@app.cell(hide_code=True)
def _(lesson, prediction):
    lesson.text(prediction, r"""
    **What you see.** Two clouds of the same shape, one in metres, one in millimetres. The integers are all that lies between them.

    Try these, one at a time:

    1. Press **L1 alone**. The cloud in the window is as small as before, but two of three epochs are crosses. A fix is good to millimetres, or
       off by decimetres and more. There is nothing between, and a single position does not tell you which of the two it is. (Lesson 04 is about
       that.)
    2. Press **Ten epochs**. The mean of ten epochs is three times better, not ten times. But the crosses are gone.
    3. Press **Start**, and move **Code noise**. The float cloud grows and shrinks with it (read the numbers on the axes: the map follows the cloud).
       The window stays as it is. Then move **Carrier noise**, under *more*. Now it is the window that changes.
    4. Press **Start**, and move **Satellites** to seven: no crosses. Then down to four. The float cloud is six times as large, and one epoch in
       nine is right.
    5. Press **Diagonal alone**. The measurements are the same. This solver rounds each ambiguity by itself, and one epoch in a thousand is right.

    **And your answer?** A hundred times. The float position is as good as the codes, the fixed one as good as the carriers: 30 cm against 3 mm.
    Satellites, frequencies and epochs decide whether you get there.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## Why it works

    ### Float, integer, fixed

    The double differences [$y$](/notation#y) of lesson 02, of codes and of carriers, follow the *mixed model*. $A$ and $B$ are known matrices,
    [$a$](/notation#a) are the *ambiguities*, whole numbers of cycles, and [$b$](/notation#b) is the baseline. The noise is $e$, with the covariance
    matrix [$Q_y$](/notation#Q_y):

    $$y = A\,a + B\,b + e, \qquad e \sim N(0,\ Q_y)$$

    With $m$ satellites on [$f$](/notation#f) frequencies there are [$n$](/notation#n) $= f\,(m - 1)$ ambiguities. It goes in three steps.

    **Float.** Forget that $a$ holds whole numbers. Least squares gives [$\hat a$](/notation#a_hat) and [$\hat b$](/notation#b_hat), and their
    covariance matrices [$Q_a$](/notation#Q_a), [$Q_b$](/notation#Q_b) and, between the two, [$Q_{ba}$](/notation#Q_ba).

    **Integer.** Find the whole numbers [$\check a$](/notation#a_fix) that fit $\hat a$ best. This is what the rest of the lesson is about.

    **Fixed.** Now the ambiguities are known, and the baseline follows:

    $$\check b = \hat b - Q_{ba}\, Q_a^{-1}\, (\hat a - \check a)$$

    In words: the integers take $\hat a - \check a$ off the ambiguities. Ambiguities and baseline are correlated, so the baseline moves along. The
    covariance of [$\check b$](/notation#b_fix) is $Q_b - Q_{ba}\, Q_a^{-1}\, Q_{ba}^{\mathsf T}$: what the ambiguities have explained is taken off.

    **How much is that?** In one epoch there are as many carriers as ambiguities. In the float solution each carrier is used up by its own ambiguity, and the
    position rests on the codes alone, with [$\sigma_P$](/notation#sigma_P). In the fixed solution the carriers are like codes that are read a hundred times better,
    with [$\sigma_\phi$](/notation#sigma_phi). Both see the same satellites, so the shape stays and the size falls by $\sigma_P / \sigma_\phi$.
    """)
    return


@app.cell(hide_code=True)
def _(lesson, prediction):
    lesson.text(prediction, r"""
    ### Why not just round?

    All float ambiguities are wrong for the same reason: the float position is wrong. If it lies half a metre too far east, the ambiguity of a
    satellite low in the east is off by two or three cycles, and that of a satellite low in the west by as many the other way. Three numbers, the
    errors of the position, make nearly all the errors. So float ambiguities do not scatter in a ball about the true integers. They scatter in a
    *needle*, long and thin.

    Two ambiguities make a plane, and you can see it. The cross is the *float point*, with the two float ambiguities as its coordinates. Move it with
    **Float value 1** and **Float value 2**, as if the noise had been another. The dashed ellipse about it is the needle. The solid blue one is the same
    needle, blown up or shrunk until it touches the nearest integers.

    The tiles are *cells*: all float points of one tile are taken to the same integers, the small dot in it. Each way of finding integers has cells of
    its own. The star is the true integers, and the outlined tile is their cell. The filled tile is the cell with the cross in it. Where both are one
    tile, the answer is right.

    The second picture is the search that finds the answer of least squares. Each *node* is an integer tried for one ambiguity. (**Ratio** says how
    much farther the second best integers are than the best. It belongs to lesson 04.)
    """)
    return


@app.cell(hide_code=True)
def _(lesson, mo):
    cells = lesson.lab("cells")
    chosen_cells, choose_cells = mo.state(None)
    return cells, choose_cells, chosen_cells


@app.cell(hide_code=True)
def _(cells, choose_cells, lesson, prediction):
    lesson.wait(prediction)
    presets_cells = cells.presets(choose_cells)
    cells.preset_row(presets_cells)
    return (presets_cells,)


@app.cell(hide_code=True)
def _(cells, controls_cells, steering_cells):
    result_cells = cells.run(steering_cells.value, controls_cells.value)
    cells.view(result_cells)
    return (result_cells,)


@app.cell(hide_code=True)
def _(cells, chosen_cells, lesson, prediction):
    lesson.wait(prediction)
    steering_cells = cells.steering(chosen_cells())
    return (steering_cells,)


@app.cell(hide_code=True)
def _(cells, chosen_cells, steering_cells):
    controls_cells = cells.controls(steering_cells.value, chosen_cells())
    cells.panel(steering_cells, controls_cells)
    return (controls_cells,)


@app.cell(hide_code=True)
def _(cells, lesson, prediction):
    lesson.wait(prediction)
    saving_cells = cells.saving()
    cells.saving_row(saving_cells)
    return (saving_cells,)


@app.cell(hide_code=True)
def _(cells, saving_cells):
    cells.link(saving_cells.value)
    return


@app.cell(hide_code=True)
def _(lesson, prediction):
    lesson.text(prediction, r"""
    **What you see.** Three ways, three answers. Rounding takes the nearest dot, as your eye does. It is wrong. Least squares takes a dot that
    looks far away, but lies along the needle. It is right.

    Try these, one at a time:

    1. Choose the **Cells of** *rounding*, then *bootstrapping*, then *least squares*. Squares, slanted boxes, hexagons along the needle. All have the same
       area, 1. Look in which tile the cross lies.
    2. Press **A thousand draws**: where the float point lies in a thousand other draws of the noise. Change the cells again: rounding is right for 28 % of them,
       bootstrapping for 39 %, least squares for 64 %.
    3. Press **Decorrelated**. The same experiment, in other integers. The needle is nearly a circle, the cells are about as long as wide, and the three
       ways agree. (The sliders still move the two ambiguities that you began with, so now the cross moves aslant.)
    4. Press **Step by step**, and move **Nodes shown** to the right. The search goes down to a first answer, then back up, to see whether another
       branch can still be better. When none can, the answer is proved.
    5. Press **Three ambiguities**, then **Three, decorrelated**. The same float point, the same answer: 46 nodes, then 7. (The plane is what is left once
       the third ambiguity is chosen. That moves the float point of the other two, from *before* to the cross.)
    6. Press **Wide lane**: one pair of satellites on two frequencies. Decorrelation finds the difference of the two by itself, $a_1 - a_2$ on the vertical
       axis. Surveyors found it by hand, and call it the *wide lane*.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ### Three ways to whole numbers

    **Rounding** takes each ambiguity for itself. It makes no use of $Q_a$. But what makes the needle stands there, beside the diagonal.

    **Bootstrapping** rounds the last one. If that moved it by 0.3 cycles, the others move along, each as far as it is correlated. Then it rounds
    the last but one, and so on. What it needs is a factorisation of the covariance matrix:

    $$Q_a = L^{\mathsf T} \operatorname{diag}(d_1, \dots, d_n)\, L$$

    In words: [$d_i$](/notation#d) is the *conditional variance* of ambiguity $i$, what is left of its variance once those after it are known.
    [$L$](/notation#L) is lower triangular with ones on its diagonal, and says how far one ambiguity moves the others.

    **Least squares** takes the whole vector at once, the one nearest in the metric of $Q_a$:

    $$\check a = \arg\min_{a}\ (\hat a - a)^{\mathsf T}\, Q_a^{-1}\, (\hat a - a)$$

    In words: blow up the ellipse about the float point until it touches a vector of integers. What is minimised is the *squared norm* of the
    second lab. No other way is right more often (Teunissen, 1999).

    How often is an answer right? Bootstrapping is right if each of its steps is, and the chance of a step is that of a normal error within half a cycle:

    $$P_s = \prod_{i=1}^{n} \left( 2\,\Phi\!\left(\frac{1}{2\sqrt{d_i}}\right) - 1 \right)$$

    Here [$P_s$](/notation#P_s) is the *success rate*, and $\Phi$ is the distribution function of the normal distribution (not the carrier phase of the
    lessons before). Least squares does as well or better. So this number, after decorrelation, is the promise of the first lab: too small rather than too
    large.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ### Decorrelation

    This is what **Decorrelated** did in the second lab. Instead of $a_1$ and $a_2$ you may look for $z_1 = -2 a_1 + 3 a_2$ and $z_2 = a_1 - a_2$. Whole numbers in, whole numbers out. And back:
    $a_1 = z_1 + 3 z_2$, $a_2 = z_1 + 2 z_2$. Nothing is lost. In general:

    $$z = Z^{\mathsf T} a, \qquad \hat z = Z^{\mathsf T} \hat a, \qquad \det Z = \pm 1$$

    In words: [$Z$](/notation#Z) holds whole numbers, and so does its inverse, as its determinant is 1 or −1. Every such
    $Z$ gives a problem with the same answer. The covariance matrix becomes $Z^{\mathsf T} Q_a Z$.

    Its determinant stays, and so does the area of the ellipse. But its form may change. You find a good $Z$ step by step: take from one ambiguity
    a whole multiple of another, so that they are correlated as little as possible; let two neighbours change places if the one that is
    fixed later is the better known. When no step helps any more, you are done.

    Decorrelation and search together are known as LAMBDA, the *least-squares ambiguity decorrelation adjustment* (Teunissen, 1995).

    ### The search

    Written with the $L$ and $d$ of $Z^{\mathsf T} Q_a Z$, the squared norm is a sum with one term for each ambiguity:

    $$(\hat z - z)^{\mathsf T} (Z^{\mathsf T} Q_a Z)^{-1} (\hat z - z) = \sum_{i=n}^{1} \frac{(z_i - c_i)^2}{d_i}$$

    Here [$z$](/notation#z) are the integers to choose, and [$c_i$](/notation#c) is the float value of $z_i$ once those after it are chosen. In words: choose the last one, the
    nearest to its float value, and pay its term. Choose the last but one and pay again. The sum only grows. So as soon as it is larger than that of the
    answers you have, leave this branch.
    """)
    return


@app.cell(hide_code=True)
def _(lesson, prediction):
    lesson.text(prediction, r"""
    ### Seven to thirty

    More than three ambiguities nobody can see. But you can see their conditional sigmas, $\sqrt{d_i}$, in the order in which the search fixes them.
    Orange: as the double differences are. Blue: after decorrelation. Mind the axis: it is logarithmic.

    The second picture shows how many nodes the search visits, for ten epochs. *Straight down* is the fewest possible.
    """)
    return


@app.cell(hide_code=True)
def _(lesson, mo):
    spectrum = lesson.lab("spectrum")
    chosen_spectrum, choose_spectrum = mo.state(None)
    return choose_spectrum, chosen_spectrum, spectrum


@app.cell(hide_code=True)
def _(choose_spectrum, lesson, prediction, spectrum):
    lesson.wait(prediction)
    presets_spectrum = spectrum.presets(choose_spectrum)
    spectrum.preset_row(presets_spectrum)
    return (presets_spectrum,)


@app.cell(hide_code=True)
def _(controls_spectrum, spectrum, steering_spectrum):
    result_spectrum = spectrum.run(steering_spectrum.value, controls_spectrum.value)
    spectrum.view(result_spectrum)
    return (result_spectrum,)


@app.cell(hide_code=True)
def _(chosen_spectrum, lesson, prediction, spectrum):
    lesson.wait(prediction)
    steering_spectrum = spectrum.steering(chosen_spectrum())
    return (steering_spectrum,)


@app.cell(hide_code=True)
def _(chosen_spectrum, spectrum, steering_spectrum):
    controls_spectrum = spectrum.controls(steering_spectrum.value, chosen_spectrum())
    spectrum.panel(steering_spectrum, controls_spectrum)
    return (controls_spectrum,)


@app.cell(hide_code=True)
def _(lesson, prediction, spectrum):
    lesson.wait(prediction)
    saving_spectrum = spectrum.saving()
    spectrum.saving_row(saving_spectrum)
    return (saving_spectrum,)


@app.cell(hide_code=True)
def _(saving_spectrum, spectrum):
    spectrum.link(saving_spectrum.value)
    return


@app.cell(hide_code=True)
def _(lesson, prediction):
    lesson.text(prediction, r"""
    **What you see.** Three large sigmas, then a fall. The search begins with the three: it must try thousands of combinations of them, and learns
    only at the fourth that nearly all of them lead nowhere. After decorrelation all sigmas are alike, and the search goes almost straight down.

    Try these, one at a time:

    1. Press **Fourteen**, then **Thirty**. However many ambiguities there are, *three* are large. With thirty, most searches without decorrelation do not end: they
       are stopped at half a million nodes, and then nobody knows whether the best one seen is the best one.
    2. Press **Seven ambiguities**, and move **Code noise**. The orange three move, the other orange ones do not. Move **Carrier noise**: now it is the
       others.
    3. Move **Epochs together**. All sigmas fall alike, and the step after the third stays. Geometry says where it is, the ratio of code to carrier
       noise how high.
    4. Press **Seven ambiguities**, then **Decorrelation off**, and look at **Bootstrapping**: right in 11.9 % of the cases, then in 0.1 %.

    The times are those of this machine, now. Watch their ratio, not their size.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ### Why three?

    The baseline has three coordinates. Before any ambiguity is fixed, only the codes know the position. So the first ambiguity is as uncertain as the codes are:
    several cycles. Fix it, and one direction is known to millimetres. After three, the position is known to millimetres, and every other ambiguity
    follows from it, up to the noise of its carrier: a few hundredths of a cycle, one or two tenths where the satellite stands low. (With a second
    frequency its first ones are some times larger again: they bring a new reading of the reference satellite, and those fixed first stand lowest.)

    The product of all $d_i$ is the determinant of $Q_a$, which no $Z$ can change. Three large ones and many small ones have the same product as many medium ones. The
    geometric mean of the sigmas has a name, *ambiguity dilution of precision*:

    $$\mathrm{ADOP} = (\det Q_a)^{1/(2n)} = \left( \prod_{i=1}^{n} \sqrt{d_i} \right)^{1/n}$$

    In words: [ADOP](/notation#ADOP) is the level at which all conditional sigmas would lie if decorrelation were perfect, in cycles. Below 0.12 nearly every fix is
    right. At 0.5, with six ambiguities or more, hardly one in ten is. It is the dotted line, before and after.

    All symbols stand on the [notation page](/notation).
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## The same in ten lines

    Copy this. It draws one epoch of six satellites on two frequencies, and solves it. The true integers are 0, 1, 2 ... 9, the true baseline is zero.

    ```python
    import numpy as np
    import gnsslab as gl
    from gnsslab.labs.skies import open_sky

    A, B, Q_y = gl.short_baseline_model(open_sky("G").spread(6).u, [0.1903, 0.2442], [0.3] * 6, [0.003] * 6)
    e = np.linalg.cholesky(Q_y) @ np.random.default_rng(1).standard_normal(20)
    found = gl.solve_float(A @ np.arange(10) + e, A, B, Q_y)
    a_fix = gl.integer_least_squares(found.a_hat, found.Q_a).best
    b_fix, Q_b_fix = gl.given_integers(found, a_fix)
    print(found.a_hat.round(1), a_fix, gl.success_rate(found.Q_a).round(4))
    print(found.b_hat.round(2), b_fix.round(4))  # [m] east, north, up
    ```

    The float ambiguities are wrong by up to 1.7 cycles. Rounded, four of ten would be wrong. The integers found are right, and the baseline goes from
    decimetres to millimetres.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## Reach a goal

    There is one goal for the first lab, two for the second, one for the third. They are judged as you move. Not all controls that help are in
    sight: look under *more*.
    """)
    return


@app.cell(hide_code=True)
def _(centimetres, result):
    centimetres.goal("thrifty", result)
    return


@app.cell(hide_code=True)
def _(cells, result_cells):
    cells.goal("luck", result_cells)
    return


@app.cell(hide_code=True)
def _(cells, result_cells):
    cells.goal("bush", result_cells)
    return


@app.cell(hide_code=True)
def _(result_spectrum, spectrum):
    spectrum.goal("straight", result_spectrum)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## Real data

    Set **Data** to *real pair* in the first lab: the two stations in Japan of lesson 02, 3335 m apart, for an hour, 120 epochs. Each epoch is solved by
    itself. What is right is known from the whole hour, solved at once. Epochs with the right integers:

    | satellites | L1 | L1 + L2 |
    |---|---|---|
    | 4 | 0.0 % | 91.7 % |
    | 5 | 13.3 % | 100.0 % |
    | 6 | 69.2 % | 100.0 % |
    | 7 | 69.5 % | 100.0 % |

    A second frequency is worth more than three more satellites. Now L1 with six satellites, and the mean of several epochs:

    | epochs together | float, real [m] | float, claimed [m] | right integers | promised |
    |---|---|---|---|---|
    | 1 | 0.40 | 0.79 | 69.2 % | 9.3 % |
    | 5 | 0.24 | 0.35 | 93.1 % | 77.2 % |
    | 20 | 0.18 | 0.18 | 98.0 % | 99.9 % |
    | 60 | 0.18 | 0.10 | 100.0 % | 100.0 % |

    * One epoch is better than claimed: these are good receivers, and the solver believes 30 cm. Move **Code noise** to 0.15 m and **Carrier noise** to
      2 mm: now the claimed cloud fits the real one. Code noise of real data is only what the solver *believes*.
    * Twenty epochs are no better than claimed, and with sixty the real cloud does not shrink any more. The claim goes on shrinking. Reflected signals last for minutes, so
      the epochs are not independent. Whoever believes the claim at sixty epochs believes too much.
    * The fixed cloud of single epochs has an rms of 4 to 5 mm: as good as the carriers are, and as the air over three kilometres lets them be.

    Set **Data** to *my files* to use your own: two receivers that stand still, and broadcast orbits.
    """)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## Reproduce

    Numbers that others have published, and what the functions of this lesson give:

    | published by | what | theirs | ours |
    |---|---|---|---|
    | de Jonge and Tiberius, 1996 | nearest integers to 5.450, 3.100, 2.970 | 5, 3, 4 | 5, 3, 4 |
    | de Jonge and Tiberius, 1996 | second nearest | 6, 4, 4 | 6, 4, 4 |
    | de Jonge and Tiberius, 1996 | squared norms of both | 0.2183, 0.3073 | 0.2183, 0.3073 |
    | LAMBDA 4.0 toolbox, example 2 | success rate, two ambiguities | 97.08 % | 97.08 % |
    | LAMBDA 4.0 toolbox, example 3 | success rate, one epoch of L1 | 30.7 % | 30.7 % |

    The covariance matrix of the first three rows is in the second lab: **Ambiguities** *three*, and under *more* **Covariance of** *a textbook* and
    **Epochs averaged** 1.

    ## Find the printed error

    Choose **The solver believes** in the first lab. At its start:

    | the solver believes | right integers | promised | ADOP | float, real [m] | float, claimed [m] |
    |---|---|---|---|---|---|
    | all it knows | 98.6 % | 95.5 % | 0.173 | 0.75 | 0.74 |
    | diagonal alone | 0.1 % | 0.0 % | 2.492 | 0.75 | 0.74 |
    | as printed: code 3 cm | 2.7 % | 100.0 % | 0.071 | 0.85 | 0.03 |

    **Paper of 1998, section 3.** Printed: the sigma of the C/A code is set to **3 cm**. Meant: 3 m, as it stands further down for the other receivers. You met the slip in
    lesson 01. There it made a promise too good by a hundred. Here it destroys integers: the solver thinks that it knows the position to 3 cm, so it
    looks for whole numbers in the wrong place. And ADOP, which sees the covariance only, says that all is well.

    **Paper of 2015, scheme 1.** Each epoch is solved by itself with least squares, and the equations, (1) to (13), hold *carriers only*. Choose *carrier alone*: with $n$ carriers there are $n$
    integers and the unknowns of the position or attitude, three too many. There is no float solution at all. The authors must have used codes. The text does not mention them.

    **Diagonal alone.** This one stands in none of the five papers of this course. It is the usual shortcut: a program hands over the float ambiguities and their sigmas,
    and forgets what is beside the diagonal. Then the nearest integers are the rounded ones. The sigmas themselves are right, and so is the promise. But an answer that is right
    once in a thousand times is of no use.
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
    waves = lesson.ask("half-a-metre-in-cycles")
    lesson.sheet("half-a-metre-in-cycles", waves)
    return (waves,)


@app.cell(hide_code=True)
def _(lesson, waves):
    lesson.check("half-a-metre-in-cycles", waves.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    box = lesson.ask("integers-in-a-box")
    lesson.sheet("integers-in-a-box", box)
    return (box,)


@app.cell(hide_code=True)
def _(box, lesson):
    lesson.check("integers-in-a-box", box.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    alone = lesson.ask("success-of-one")
    lesson.sheet("success-of-one", alone)
    return (alone,)


@app.cell(hide_code=True)
def _(alone, lesson):
    lesson.check("success-of-one", alone.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    by_hand = lesson.ask("bootstrapping-by-hand")
    lesson.sheet("bootstrapping-by-hand", by_hand)
    return (by_hand,)


@app.cell(hide_code=True)
def _(by_hand, lesson):
    lesson.check("bootstrapping-by-hand", by_hand.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    determinant = lesson.ask("determinant-after-decorrelation")
    lesson.sheet("determinant-after-decorrelation", determinant)
    return (determinant,)


@app.cell(hide_code=True)
def _(determinant, lesson):
    lesson.check("determinant-after-decorrelation", determinant.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    mean = lesson.ask("adop-of-four")
    lesson.sheet("adop-of-four", mean)
    return (mean,)


@app.cell(hide_code=True)
def _(lesson, mean):
    lesson.check("adop-of-four", mean.value)
    return


@app.cell(hide_code=True)
def _(lesson):
    epochs = lesson.ask("epochs-for-adop")
    lesson.sheet("epochs-for-adop", epochs)
    return (epochs,)


@app.cell(hide_code=True)
def _(epochs, lesson):
    lesson.check("epochs-for-adop", epochs.value)
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## What can go wrong

    * **Fixing too early.** A wrong fix is worse than none: it claims millimetres and is off by decimetres or metres. Lesson 04 is about when to believe.
    * **Sigmas that are guessed.** The integers hang on the ratio of code to carrier noise, and the promise hangs on both. The table above shows what one wrong sigma does.
    * **A bias.** An error that does not average out, from a reflected signal or a receiver that is half a cycle off, moves the whole needle. No success rate knows of it.
    * **A slip.** An ambiguity that changes between two epochs must not go into one mean.
    * **Mixing systems.** Between satellites of GPS and GLONASS, or of GLONASS alone with receivers of two makers, the double-difference ambiguity may be no integer at all.
    * **A long baseline.** Beyond ten or twenty kilometres the ionosphere no longer cancels, and the float point is off by more than its needle says.
    * **A search that was stopped.** A program with a limit must say when it hit it. Ours does: `integer_least_squares(...).complete`.

    ## Sources

    * P. J. G. Teunissen: *The least-squares ambiguity decorrelation adjustment: a method for fast GPS integer ambiguity estimation*. Journal of Geodesy 70, 65–82, 1995.
    * P. de Jonge, C. Tiberius: *The LAMBDA method for integer ambiguity estimation: implementation aspects*. LGR-Series 12, Delft, 1996.
    * P. J. G. Teunissen: *Success probability of integer GPS ambiguity rounding and bootstrapping*. Journal of Geodesy 72, 606–612, 1998, and *An optimality property of the
      integer least-squares estimator*. Journal of Geodesy 73, 587–593, 1999.
    * L. Massarweh, S. Verhagen, P. J. G. Teunissen: *LAMBDA 4.0 toolbox*. Delft University of Technology, 2024. Examples 2 and 3.
    * X. Chang, X. Yang, T. Zhou: *MLAMBDA: a modified LAMBDA method for integer least-squares estimation*. Journal of Geodesy 79, 552–565, 2005.
    * D. Odijk, P. J. G. Teunissen: *ADOP in closed form for a hierarchy of multi-frequency single-baseline GNSS models*. Journal of Geodesy 82, 473–492, 2008.
    * X. Yuan, G. Hu, Z. Duan: *Low-cost GPS attitude experiments*. Third annual meeting of the China GPS association, 1998. Section 3.
    * Y. Gan, L. Sui, C. Liu, M. Dong: *Instantaneous GNSS attitude by adaptive robust filtering*. Acta Geodaetica et Cartographica Sinica, 2015. Equations (1) to (13), scheme 1.
    * Real data: `geonet-0759-3040`, GEONET stations of the Geospatial Information Authority of Japan, 2 April 2005, 30 s, from the test data of RTKLIB.
    """)
    return


if __name__ == "__main__":
    app.run()
