"""Exercises of lesson 00: heading, pitch and how sharp they are."""

from gnsslab.teaching.questions import Prediction, Question, UsualMistake

PREDICTION = Prediction(
    name="how-well-in-one-second",
    text="How well can the two receivers together tell the beam's direction, within one second?",
    options=("not at all", "to about 20 degrees", "to about 2 degrees", "to a few tenths of a degree"),
    answer="to a few tenths of a degree",
)

QUESTIONS = (
    Question(
        name="heading-of-a-beam",
        text="The second antenna is 0.70 m east and 0.40 m **south** of the first. What is the heading of the beam?",
        answer=119.7449,
        tolerance=0.2,
        unit="deg",
        period=360.0,
        hints=(
            "Write the baseline as $e$ and $n$, with signs. South is negative north, so $n = -0.40$ m.",
            r"The beam points between east (90°) and south (180°). A plain $\arctan(e/n)$ cannot know that: use $\operatorname{atan2}(e,\ n)$.",
        ),
        solution=(
            r"With $e = 0.70$ m and $n = -0.40$ m: $\psi = \operatorname{atan2}(0.70,\ -0.40) = 119.7°$." "\n\n"
            "Check it with a sketch. From east the beam turns a further $29.7°$ towards south, because $0.40/0.70 = \\tan 29.7°$. "
            "And $90° + 29.7° = 119.7°$."
        ),
        mistakes=(
            UsualMistake(-60.2551, r"That is $\arctan(e/n)$: it sees only the quotient and points the wrong way. Use atan2: it looks at both signs."),
            UsualMistake(60.2551, "You took $n$ as positive, so the beam points to the north-east. South means that $n$ is negative."),
            UsualMistake(-29.7449, "You swapped $e$ and $n$. You measured from east, counter-clockwise. Heading goes from north, clockwise."),
            UsualMistake(-119.7449, "The size is right, but you counted counter-clockwise. Heading grows clockwise, from north over east."),
            UsualMistake(2.0899, "That is in radians. Multiply by $180/\\pi$."),
        ),
    ),
    Question(
        name="sigma-of-heading",
        text=(
            "A level beam is 1.2 m long. The error of its far end *across* the beam has a standard deviation of 3 mm. "
            "What is the standard deviation of heading?"
        ),
        answer=0.143239,
        tolerance=0.004,
        unit="deg",
        hints=(
            "A small angle is the distance across divided by the distance along. Take both in the same unit.",
            "The quotient is in radians. Multiply by $180/\\pi = 57.3$ to get degrees.",
        ),
        solution=(
            r"$\sigma_\psi = 3\ \text{mm} / 1200\ \text{mm} = 0.0025$ rad, and $0.0025 \cdot 57.3° = 0.143°$." "\n\n"
            "Three millimetres at the end of a beam that you can carry: a seventh of a degree."
        ),
        mistakes=(
            UsualMistake(0.0025, "That is right in radians. The quotient of two lengths is in radians; multiply by $180/\\pi$."),
            UsualMistake(2.5, "You divided millimetres by metres. That gives thousandths of a radian. Take both in metres, then convert to degrees."),
            UsualMistake(143.239, "You divided millimetres by metres. Take both in the same unit."),
        ),
    ),
    Question(
        name="length-for-a-sigma",
        text="The same receivers: still 3 mm across the beam. You want a standard deviation of heading of 0.05 deg. How long must the beam be?",
        answer=3.43775,
        tolerance=0.05,
        unit="m",
        hints=(
            "Turn the formula round: the length is the error across divided by the angle.",
            r"The angle must be in radians: $0.05° = 0.05 \cdot \pi / 180 = 0.000873$ rad.",
        ),
        solution=(
            r"$\ell = 3\ \text{mm} / 0.000873 = 3438$ mm $= 3.44$ m." "\n\n"
            "Length buys sharpness, nothing else: the whole numbers of a long beam are as hard to find as those of a short one."
        ),
        mistakes=(
            UsualMistake(0.06, "You divided by degrees. The angle must be in radians: 0.05 deg is 0.000873 rad."),
            UsualMistake(60.0, "You divided by degrees, and the result is in millimetres. Take the angle in radians and the error in metres."),
            UsualMistake(3437.75, "That is in millimetres. The answer is asked in metres."),
            UsualMistake(9.8484, "You squared the gain. The variance falls with the square of the length, sigma with the length itself."),
        ),
    ),
    Question(
        name="swapped-cables",
        text="The engine shows a heading of 35 deg and a pitch of 4 deg. Then someone swaps the two antenna cables. Which heading does it show now?",
        answer=215.0,
        tolerance=0.5,
        unit="deg",
        period=360.0,
        hints=(
            "Swapped cables make the first antenna the second. What happens to the baseline, the arrow from one to the other?",
            "Every component changes its sign: $e$, $n$ and $u$. An arrow that is reversed points the opposite way.",
        ),
        solution=(
            "The baseline changes its sign, so heading turns by $180°$: $35° + 180° = 215°$. Pitch changes its sign: it is now $-4°$." "\n\n"
            "No test of the engine can see it: the length is right, and so are the whole numbers. Mark the cables."
        ),
        mistakes=(
            UsualMistake(35.0, "The engine does not know which antenna is in front. It takes the baseline from the first receiver to the second."),
            UsualMistake(-35.0, "Only one of $e$ and $n$ changed its sign here. Both do."),
            UsualMistake(145.0, "Only $n$ changed its sign here. $e$ does too, so add half a turn and do not subtract from it."),
        ),
    ),
    Question(
        name="sigma-of-a-tilted-beam",
        text=(
            r"A beam of 1.5 m has a heading of 60 deg and a pitch of 30 deg. The standard deviations of its far end are "
            r"$\sigma_e = 5$ mm, $\sigma_n = 8$ mm and $\sigma_u = 12$ mm, without correlation. What is the standard deviation of heading?"
        ),
        answer=0.324863,
        tolerance=0.004,
        unit="deg",
        hints=(
            r"Across the beam, on the level: $\sqrt{\cos^2\!\psi\,\sigma_e^2 + \sin^2\!\psi\,\sigma_n^2}$. It should be 7.4 mm.",
            r"Seen from above, the beam is only $\ell\cos\theta = 1.30$ m long. Divide by that, then convert from radians.",
        ),
        solution=(
            r"Across: $\sqrt{0.25 \cdot 25 + 0.75 \cdot 64} = 7.37$ mm. From above the beam is $1500 \cdot \cos 30° = 1299$ mm long. "
            r"So $\sigma_\psi = 7.37 / 1299 = 0.00567$ rad $= 0.325°$." "\n\n"
            "A beam that points east is turned by errors to the north, and the other way round. That is why $\\cos\\psi$ goes with $\\sigma_e$."
        ),
        mistakes=(
            UsualMistake(0.00567, "That is in radians. Multiply by $180/\\pi$."),
            UsualMistake(0.28134, r"You forgot $\cos\theta$: seen from above, a tilted beam is shorter, so the same millimetres turn it further."),
            UsualMistake(0.26001, r"You swapped the sigmas. $\cos\psi$ goes with $\sigma_e$: errors to the east turn a beam that points north."),
            UsualMistake(2.3928, "You forgot the root: that is a variance divided by a length. Take the root before you divide."),
        ),
    ),
    Question(
        name="pitch-as-printed",
        text=r"A mast has a true pitch of 25 deg. Which pitch does the formula as printed give, $\arcsin(u/h)$ with $h = \sqrt{e^2+n^2}$?",
        answer=27.7949,
        tolerance=0.05,
        unit="deg",
        hints=(
            r"What is $u/h$ at a pitch of 25 deg? It is the opposite side over the adjacent side.",
            r"$u/h = \tan 25° = 0.46631$. Now take the arcsin of it.",
        ),
        solution=(
            r"$u/h = \tan 25° = 0.46631$ and $\arcsin(0.46631) = 27.79°$: an error of $2.79°$." "\n\n"
            r"Small angles err by $\theta^3/2$ (in radians): on a level roof nobody sees it. Above 45 deg, $u/h$ exceeds one and has no arcsin."
        ),
        mistakes=(
            UsualMistake(25.0, r"That is the true pitch. The corrected $\operatorname{atan2}(u,\ h)$ gives it; the printed formula takes an arcsin."),
            UsualMistake(22.9098, r"You took $\arctan(\sin\theta)$. The print has it the other way round: the arcsin of a tangent."),
            UsualMistake(0.48511, "That is in radians. Multiply by $180/\\pi$."),
        ),
    ),
)  # fmt: skip
