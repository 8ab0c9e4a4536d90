import marimo

__generated_with = "0.25.2"
app = marimo.App(width="medium", app_title="Which way is north?")


@app.cell
def _():
    import marimo as mo

    from gnsslab.labs.north import north_lab
    from gnsslab.teaching.catalogue import find_lesson
    from gnsslab.teaching.marimo_front import LabFront, goal, lesson_head

    return LabFront, find_lesson, goal, lesson_head, mo, north_lab


@app.cell
def _(find_lesson, lesson_head):
    lesson_head(find_lesson("00"))
    return


@app.cell
def _(mo):
    prediction = mo.ui.radio(["a", "b"], label="How much?")
    prediction
    return (prediction,)


@app.cell
def _(LabFront, mo, north_lab):
    front = LabFront(north_lab())
    chosen, choose = mo.state(None)
    return choose, chosen, front


@app.cell
def _(choose, front, mo, prediction):
    mo.stop(prediction.value is None, mo.md("Choose an answer first."))
    presets = front.presets(choose)
    return (presets,)


@app.cell
def _(chosen, front, presets):
    front.preset_row(presets, chosen())
    return


@app.cell
def _(chosen, front):
    steering = front.steering(chosen())
    return (steering,)


@app.cell
def _(chosen, front, steering):
    controls = front.controls(steering.value, chosen())
    return (controls,)


@app.cell
def _(controls, front, presets, steering):
    front.panel(steering, controls) if presets else None
    return


@app.cell
def _(controls, front, presets, steering):
    result = front.run(steering.value, controls.value) if presets else None
    front.view(result)
    return (result,)


if __name__ == "__main__":
    app.run()
