"""A small lesson as a marimo file, with one of everything that a lesson may have."""

OPENING = """
import marimo

app = marimo.App()


@app.cell(hide_code=True)
def _():
    import marimo as mo

    from gnsslab.teaching.marimo_front import open_lesson

    lesson = open_lesson("00")
    return lesson, mo
"""

HEAD = """
@app.cell(hide_code=True)
def _(lesson):
    lesson.head()
    return
"""

TEXT = '''
@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## The scene

    Heading is $\\psi$, see the [notation](/notation#psi).
    """)
    return
'''

PREDICTION = """
@app.cell(hide_code=True)
def _(lesson):
    prediction = lesson.prediction()
    prediction
    return (prediction,)


@app.cell(hide_code=True)
def _(lesson, prediction):
    lesson.predicted(prediction)
    return
"""

LAB = """
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
def _(controls, north, steering):
    result = north.run(steering.value, controls.value)
    north.view(result)
    return (result,)
"""

LATER_TEXT = '''
@app.cell(hide_code=True)
def _(lesson, prediction):
    lesson.text(prediction, r"""
    ## Play

    Blue is *fixed*.
    """)
    return
'''

GOAL = """
@app.cell(hide_code=True)
def _(north, result):
    north.goal("sharp", result)
    return
"""

QUESTION = """
@app.cell(hide_code=True)
def _(lesson):
    beam = lesson.ask("heading-of-a-beam")
    lesson.sheet("heading-of-a-beam", beam)
    return (beam,)


@app.cell(hide_code=True)
def _(beam, lesson):
    lesson.check("heading-of-a-beam", beam.value)
    return
"""

WHOLE = OPENING + HEAD + TEXT + PREDICTION + LAB + LATER_TEXT + GOAL + QUESTION


def cell(body):
    """Return a marimo cell of one line, after the opening."""
    return f"{OPENING}\n@app.cell\ndef _(lesson, mo, north):\n    {body}\n    return\n"
