"""Exercises of lesson 02: what cancels, what grows, and what differences have in common."""

from gnsslab.teaching.questions import Prediction, Question, UsualMistake

PREDICTION = Prediction(
    name="how-much-is-left",
    text=(
        "From the rover's two carrier phases you take away the master's two, then one satellite from the other. "
        "How far is the result from a whole number of waves?"
    ),
    options=("kilometres", "metres", "decimetres", "millimetres"),
    answer="millimetres",
)

QUESTIONS = (
    Question(
        name="sigma-of-a-double-difference",
        text=(
            "One carrier phase of one receiver has a standard deviation of 3 mm, for every satellite and both receivers. "
            "What is the standard deviation of a double difference?"
        ),
        answer=6.0,
        tolerance=0.05,
        unit="mm",
        hints=(
            "A double difference is made of four readings. Their errors are independent: variances add, whatever the signs.",
            "Four times the variance. How many times the standard deviation is that?",
        ),
        solution=(
            r"Four independent readings: $\sigma_{\nabla\Delta}^2 = 4\sigma^2 = 4 \cdot 9\ \text{mm}^2 = 36\ \text{mm}^2$, so "
            r"$\sigma_{\nabla\Delta} = 2\sigma = 6$ mm." "\n\n"
            r"The single difference stands between: two readings, $\sqrt{2} \cdot 3$ mm $= 4.2$ mm."
        ),
        mistakes=(
            UsualMistake(36.0, "That is the variance, in square millimetres. The standard deviation is its root."),
            UsualMistake(12.0, "The variance grows four times. The standard deviation grows with its root: twice."),
            UsualMistake(4.2426, r"That is the single difference, $\sqrt{2}\,\sigma$: two readings. A double difference has four."),
            UsualMistake(3.0, "Errors do not cancel in a difference, only what is common does. The noise of the four readings is not common."),
        ),
    ),
    Question(
        name="correlation-of-two-differences",
        text=(
            "Two double differences have the same reference satellite. All readings are equally good. "
            "What is the correlation coefficient of the two?"
        ),
        answer=0.5,
        tolerance=0.01,
        unit="",
        hints=(
            "Look at the matrix: 4 on the diagonal, 2 beside it.",
            "A correlation coefficient is the covariance over the root of the product of the two variances.",
        ),
        solution=(
            r"Covariance $2\sigma^2$, from the two readings of the reference that both share. Variances $4\sigma^2$ each. "
            r"So $2\sigma^2 / \sqrt{4\sigma^2 \cdot 4\sigma^2} = \tfrac12 = 0.5$."
        ),
        mistakes=(
            UsualMistake(0.0, "They share the two readings of the reference satellite. If those are off, both differences are off together."),
            UsualMistake(2.0, "That is the covariance, in units of the variance of one reading. Divide by the variance of a double difference."),
            UsualMistake(0.25, "That is one reading shared of four. They share two: the reference's, of both receivers."),
            UsualMistake(0.7071, "That is the root of it. The coefficient is covariance over variance here: no root is left."),
        ),
    ),
    Question(
        name="correlation-with-a-poor-reference",
        text=(
            "Now the reference stands low: its readings have a standard deviation of 6 mm, those of the other satellites 3 mm. "
            "What is the correlation coefficient of two double differences?"
        ),
        answer=0.8,
        tolerance=0.01,
        unit="",
        hints=(
            "The covariance of two double differences is the variance of what they share: the reference's single difference.",
            r"With $\sigma_1$ for the reference and $\sigma_s$ for the others: covariance $2\sigma_1^2$, variance $2\sigma_1^2 + 2\sigma_s^2$.",
        ),
        solution=(
            r"$\dfrac{2\sigma_1^2}{2\sigma_1^2 + 2\sigma_s^2} = \dfrac{36}{36 + 9} = 0.8$." "\n\n"
            "The worse the reference, the more alike all differences are. A solver that is told so takes the common error out again. "
            "One that is not told takes it for many good reasons to believe the same wrong thing."
        ),
        mistakes=(
            UsualMistake(0.5, "That holds only where all readings are equally good. Here the reference is worse than the others."),
            UsualMistake(0.6667, "You took standard deviations, 6 / (6 + 3). Variances add: square them first. The paper of 2019 forgot it too."),
            UsualMistake(0.2, "That is the other satellite's share. What the two differences share is the reference."),
        ),
    ),
    Question(
        name="millisecond-of-the-rover",
        text=(
            "The rover's clock is 1 ms off, and you believe its time tags. A satellite's distance grows by 450 m/s, that of the reference shrinks "
            "by 250 m/s. By how much is the double difference wrong?"
        ),
        answer=0.70,
        tolerance=0.005,
        unit="m",
        hints=(
            "You compute where each satellite is a millisecond too late or too early. How far is that along the line of sight?",
            "One distance grows, the other shrinks: take the difference with its signs, $450 - (-250)$ m/s.",
        ),
        solution=(
            r"$(450 - (-250))\ \text{m/s} \cdot 0.001\ \text{s} = 0.70$ m: more than three wavelengths." "\n\n"
            "The remedy costs nothing. Tag minus code over $c$ is the moment at which the signal left, whatever the clock says, because the code "
            "contains the same clock error as the tag."
        ),
        mistakes=(
            UsualMistake(0.2, "You took 450 less 250. One distance grows and the other shrinks, so their rates have different signs."),
            UsualMistake(0.45, "You forgot the reference satellite. It moves too."),
            UsualMistake(700.0, "That is for a whole second. A millisecond is a thousandth of it."),
            UsualMistake(299_792.458, "That is how far light travels in a millisecond. Both satellites' measurements have it, so it cancels."),
        ),
    ),
    Question(
        name="how-many-double-differences",
        text=(
            "Both receivers track 6 GPS satellites on L1 and 5 Galileo satellites on E1. Differences are formed within each system. "
            "How many independent double differences are there?"
        ),
        answer=9.0,
        tolerance=0.4,
        unit="",
        hints=(
            "In each system one satellite is the reference. It has no double difference of its own.",
            "$m - 1$ for each of the two systems.",
        ),
        solution=(
            "$(6 - 1) + (5 - 1) = 9$. All other double differences, of other pairs, are sums and differences of these: they bring nothing new." "\n\n"
            "Across systems a receiver delays the signals differently, so each system keeps a reference of its own."
        ),
        mistakes=(
            UsualMistake(11.0, "One for every satellite: but the reference of each system is used up."),
            UsualMistake(10.0, "You took one reference for both systems. Within each system there is one of its own."),
            UsualMistake(25.0, "You counted all pairs. Only those against the reference are independent; the others follow from them."),
        ),
    ),
    Question(
        name="two-v",
        text=(
            "Equation (7) of the paper of 1998 writes the noise of a single difference as $2V$, where $V$ is the noise of one receiver. "
            "How many times larger than the right one is the standard deviation of a double difference that follows from it?"
        ),
        answer=1.414214,
        tolerance=0.005,
        unit="",
        hints=(
            r"What is the variance of $2V$, and what is the variance of the difference of two independent $V$?",
            r"$4\sigma^2$ against $2\sigma^2$. The double difference inherits the factor.",
        ),
        solution=(
            r"$2V$ has the variance $4\sigma^2$; the difference $V_m - V_j$ of two independent receivers has $2\sigma^2$. The factor 2 stays "
            r"through the second difference: 8-4-4 instead of 4-2-2. The standard deviation is $\sqrt2 = 1.41$ times too large." "\n\n"
            "The ratio does not notice, because both its norms shrink alike. The promise of success does: 65 instead of 94 % in the lab."
        ),
        mistakes=(
            UsualMistake(2.0, "That is the factor of the variance. The standard deviation is its root."),
            UsualMistake(4.0, "$2V$ has four times the variance of $V$. But the right difference of two receivers has twice that of $V$ already."),
            UsualMistake(0.7071, "The other way round: the printed one is the larger."),
            UsualMistake(1.0, "The ratios are the same, but not the standard deviations: look at the ellipse and at what is claimed."),
        ),
    ),
)  # fmt: skip
