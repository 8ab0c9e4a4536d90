"""Exercises of lesson 03: from cycles to centimetres, how many integers there are to try, and what decorrelation leaves alone."""

from gnsslab.teaching.questions import Prediction, Question, UsualMistake

PREDICTION = Prediction(
    name="how-much-sharper",
    text=(
        "A code is read to 30 cm, a carrier to 3 mm. One epoch of codes and carriers gives a position that is good to 75 cm. "
        "Then you find out the whole numbers in the carriers, and measure nothing else. How many times better is the position?"
    ),
    options=("twice", "ten times", "a hundred times", "a thousand times"),
    answer="a hundred times",
)

QUESTIONS = (
    Question(
        name="half-a-metre-in-cycles",
        text=(
            "The float position is half a metre too close to a satellite. By how many cycles does that put the float ambiguity of this satellite "
            "wrong on L1, with a wavelength of 19.03 cm?"
        ),
        answer=2.627,
        tolerance=0.01,
        unit="cycles",
        hints=(
            "A carrier counts waves along the line to the satellite. How many of them fit into the half metre?",
            "Half a metre over the length of one wave, both in the same unit.",
        ),
        solution=(
            r"$0.5\ \text{m} / 0.1903\ \text{m} = 2.627$ cycles. Rounding gives the right integer as long as you are off by less than half a cycle, "
            "that is 10 cm. So the float position alone does not tell the integer of a single satellite."
        ),
        mistakes=(
            UsualMistake(0.09515, "You multiplied by the wavelength. The number of waves is the distance over the length of one."),
            UsualMistake(0.3806, "That is the wavelength over the distance: turn it round."),
            UsualMistake(26.27, "A slip of the unit: the wavelength is 0.19 m, not 0.019 m."),
            UsualMistake(3.0, "That is rounded up. The float value has a fraction, and this lesson is about not rounding too early."),
        ),
    ),
    Question(
        name="integers-in-a-box",
        text=(
            "Each of seven float ambiguities happens to be a whole number, and each has a sigma of 5 cycles. How many integer vectors lie in the box "
            "of three sigma to both sides? Count in thousands of millions."
        ),
        answer=27.51,
        tolerance=0.3,
        unit="",
        hints=(
            "How many integers lie from 15 below to 15 above, both ends and the middle counted? Each ambiguity has that many choices.",
            r"$(2 \cdot 15 + 1)^7$.",
        ),
        solution=(
            r"From $-15$ to $15$ there are 31 integers, and $31^7 = 27\,512\,614\,111$, so 27.51 thousand millions. At a hundred million a second "
            "that is nearly five minutes for one epoch, and the next one is a second away. The search of this lesson visits some thirty nodes."
        ),
        mistakes=(
            UsualMistake(21.87, "You counted 30 integers a side. The one in the middle belongs to it as well."),
            UsualMistake(0.170859, "You went to one side only: the box reaches three sigma below and three sigma above."),
            UsualMistake(217.0, "The choices multiply, they do not add: each integer of the first goes with each of the second."),
            UsualMistake(0.019487, "That is eleven integers a side: one sigma. The box has three."),
        ),
    ),
    Question(
        name="success-of-one",
        text="One ambiguity, by itself, has a sigma of 0.2 cycles. You round it. How often is the integer right? Answer in percent.",
        answer=98.758,
        tolerance=0.1,
        unit="%",
        hints=(
            "It rounds to the right integer as long as its error stays within half a cycle. How many sigmas is that?",
            r"$P = 2\,\Phi(2.5) - 1$, with $\Phi$ of the normal distribution.",
        ),
        solution=(
            r"Half a cycle is $0.5 / 0.2 = 2.5$ sigma, and $2\,\Phi(2.5) - 1 = 2 \cdot 0.99379 - 1$, which is 98.758 %."
            "\n\n"
            "It sounds good. With ten such ambiguities, uncorrelated, 88 % is left: all of them must be right at once."
        ),
        mistakes=(
            UsualMistake(99.379, r"That is $\Phi(2.5)$, which bounds the error on one side only. It may be too low as well as too high."),
            UsualMistake(73.645, "You took 0.2 for the variance. It is the standard deviation: no root."),
            UsualMistake(68.269, "That is one sigma. Half a cycle is more than that here."),
            UsualMistake(99.9999, "You took a whole cycle. Beyond half a cycle it already rounds to the neighbour."),
        ),
    ),
    Question(
        name="bootstrapping-by-hand",
        text=(
            r"Two float ambiguities are $\hat a = (5.2,\ 2.6)$. Their variances are 0.7 and 0.5, their covariance is 0.4, all in cycles². "
            "Bootstrapping fixes the second one first, at 3. What is the float value of the first one then?"
        ),
        answer=5.52,
        tolerance=0.005,
        unit="cycles",
        hints=(
            "The second one turned out to be 0.4 larger than its float value. The two are correlated: what does that tell of the first?",
            r"For each cycle that the second one moves, the first one moves by covariance over the variance of the second: $0.4 / 0.5$.",
        ),
        solution=(
            r"$5.2 + \dfrac{0.4}{0.5}\,(3 - 2.6) = 5.2 + 0.8 \cdot 0.4 = 5.52$ cycles. So bootstrapping says 6, where rounding said 5."
        ),
        mistakes=(
            UsualMistake(5.2, "That is the value before. The second one has moved by 0.4, and the first one is correlated with it."),
            UsualMistake(4.88, "The sign: both move the same way, as their covariance is positive."),
            UsualMistake(5.36, "You multiplied by the covariance. Divide it by the variance of the second ambiguity first."),
            UsualMistake(5.42857, "You divided by the variance of the first one. It is the second one that became known."),
            UsualMistake(4.72, "You fixed the second one at 2. Its float value is 2.6, nearer to 3."),
        ),
    ),
    Question(
        name="determinant-after-decorrelation",
        text=(
            r"The same two ambiguities, with variances 0.7 and 0.5 and covariance 0.4. Decorrelation takes $z_1 = a_1 - a_2$ and $z_2 = a_2$. "
            "What is the determinant of the covariance matrix of the new ones?"
        ),
        answer=0.19,
        tolerance=0.002,
        unit="",
        hints=(
            r"You need not work out the new matrix. What does $Z^{\mathsf T} Q_a Z$ do to a determinant?",
            r"$\det(Z^{\mathsf T} Q_a Z) = (\det Z)^2 \det Q_a$, and $\det Z = 1$.",
        ),
        solution=(
            r"$\det Q_a = 0.7 \cdot 0.5 - 0.4^2 = 0.19$, and it stays. The new variances are $0.7 + 0.5 - 2 \cdot 0.4 = 0.4$ and 0.5, the new "
            r"covariance is $0.4 - 0.5 = -0.1$: indeed $0.4 \cdot 0.5 - 0.1^2 = 0.19$."
            "\n\n"
            "The area of the ellipse stays; its length does not. That is all decorrelation does, and all it needs to do."
        ),
        mistakes=(
            UsualMistake(0.35, "That is the product of the variances. The covariance, squared, is to be taken off."),
            UsualMistake(0.51, "You added the square of the covariance. It is taken off."),
            UsualMistake(0.2, "That is the product of the new variances. The new covariance is small, but it is not zero."),
            UsualMistake(0.0361, "You squared the determinant. It is that of $Z$ which comes in squared, and that is 1."),
        ),
    ),
    Question(
        name="adop-of-four",
        text="Four ambiguities have conditional sigmas of 16, 4, 0.05 and 0.02 cycles, in the order in which they are fixed. What is ADOP?",
        answer=0.50297,
        tolerance=0.004,
        unit="cycles",
        hints=(
            "ADOP is their geometric mean: multiply, then take a root. Which one?",
            r"$(16 \cdot 4 \cdot 0.05 \cdot 0.02)^{1/4}$.",
        ),
        solution=(
            r"$16 \cdot 4 \cdot 0.05 \cdot 0.02 = 0.064$, and $0.064^{1/4} = 0.503$ cycles."
            "\n\n"
            "Decorrelation could make all four about that large. The search would then have hardly more than one choice at each level. "
            "As they are, it has dozens at the first and none at the last."
        ),
        mistakes=(
            UsualMistake(5.0175, "That is the arithmetic mean, which the largest one makes alone. The product stays, so the mean is geometric."),
            UsualMistake(0.064, "That is the product. The fourth root is missing."),
            UsualMistake(0.70921, r"You took the eighth root. The $2n$ is for the determinant, which is a product of variances. These are sigmas."),
            UsualMistake(0.25298, "That is the square root. There are four of them."),
        ),
    ),
    Question(
        name="epochs-for-adop",
        text=(
            "One epoch has an ADOP of 0.36 cycles. Noise is new at every epoch, and the satellites hardly move. The mean of how many epochs brings "
            "it down to 0.12?"
        ),
        answer=9.0,
        tolerance=0.4,
        unit="epochs",
        hints=(
            "ADOP is a mean of sigmas. How does a sigma shrink when you take the mean of many epochs?",
            "ADOP is to be a third. A sigma falls with the root of the number of epochs.",
        ),
        solution=(
            "All sigmas shrink with the root of the number of epochs, and their geometric mean with them. The root is $0.36 / 0.12 = 3$, so 9 epochs."
            "\n\n"
            "In real data it takes more: reflections last for minutes, so the noise of the next epoch is not new."
        ),
        mistakes=(
            UsualMistake(3.0, "ADOP is to be a third, but it falls only with the root of the number of epochs."),
            UsualMistake(81.0, "You squared twice. ADOP is a mean of sigmas, not of variances."),
            UsualMistake(1.7321, "You took the root where the square belongs: a third of the sigma needs more than three epochs, not fewer."),
        ),
    ),
)  # fmt: skip
