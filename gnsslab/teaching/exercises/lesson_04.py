"""Exercises of lesson 04: what a promise is worth, what a test decides, and what lies between fixed and float."""

from gnsslab.teaching.questions import Prediction, Question, UsualMistake

PREDICTION = Prediction(
    name="how-many-are-wrong",
    text="Five satellites, one frequency, each epoch alone. Thirteen of the 101 epochs pass the test. How many of these thirteen fixes are wrong?",
    options=("none", "one", "four", "eight"),
    answer="eight",
)

QUESTIONS = (
    Question(
        name="success-rate-of-one",
        text=r"One ambiguity has a sigma of a quarter of a cycle, and no bias. How often does rounding find the right integer?",
        answer=95.45,
        tolerance=0.1,
        unit="%",
        hints=(
            "Rounding is right as long as the error is less than half a cycle, on either side. How many sigmas are that?",
            r"Two. $2\,\Phi(2) - 1$: what share of a normal distribution lies within two sigmas?",
        ),
        solution=(
            r"$2\,\Phi\!\left(\frac{1}{2\sigma}\right) - 1 = 2\,\Phi(2) - 1 = 0.9545$: 95.45 %." "\n\n"
            "At a sigma of a fifth of a cycle it is 98.8 %, and at a tenth fewer than one fix in a million is wrong."
        ),
        mistakes=(
            UsualMistake(97.72, r"That is $\Phi(2)$: errors to one side only. An error of half a cycle may go either way."),
            UsualMistake(68.27, "That is within one sigma. Half a cycle is two of them here."),
            UsualMistake(99.9937, "That is within four sigmas, a whole cycle. Rounding goes wrong from half a cycle on."),
            UsualMistake(0.9545, "That is the share of one. In per cent it is a hundred times that."),
        ),
    ),
    Question(
        name="adop-and-many",
        text=r"A model has $n = 20$ ambiguities and an ADOP of 0.20 cycles. What success rate does ADOP stand for?",
        answer=77.88,
        tolerance=0.3,
        unit="%",
        hints=(
            "Think of 20 ambiguities, uncorrelated, each with a sigma of 0.20 cycles. All must be right.",
            r"One is right with $2\,\Phi(2.5) - 1 = 0.98758$. Take the 20th power.",
        ),
        solution=(
            r"$\left(2\,\Phi\!\left(\frac{1}{2 \cdot 0.20}\right) - 1\right)^{20} = 0.98758^{20} = 0.779$: 77.9 %." "\n\n"
            "With 28 ambiguities it is 70 %, with five 94 %. The same ADOP means less where there are more ambiguities."
        ),
        mistakes=(
            UsualMistake(98.758, "That is one ambiguity. All 20 must be right at once."),
            UsualMistake(75.16, "You took 1.24 % of failures 20 times. Chances of being right are multiplied, not added up."),
            UsualMistake(88.29, r"You raised $\Phi(2.5)$ to the 20th power: errors to one side only."),
        ),
    ),
    Question(
        name="mu-turned-round",
        text=(
            "A table of TU Delft asks best over second best to be no more than $\\mu = 0.43$. "
            "What must second best over best reach in a program that asks it the other way round?"
        ),
        answer=2.3256,
        tolerance=0.02,
        unit="",
        hints=(
            "Both tests shall believe the same fixes.",
            r"Turn a ratio round, and you turn the limit round, and what must be less must now be more.",
        ),
        solution=(
            r"$\dfrac{\text{best}}{\text{second}} \le 0.43$ is the same as $\dfrac{\text{second}}{\text{best}} \ge \dfrac{1}{0.43} = 2.33$." "\n\n"
            "The number 0.43 given to the other program asks for nothing: second over best is never below 1."
        ),
        mistakes=(
            UsualMistake(0.43, "Second over best is never below 1, so this believes everything."),
            UsualMistake(0.57, "One minus it. The ratio was turned round: take one over it."),
            UsualMistake(5.408, "You squared it. Both tests look at squared distances already."),
        ),
    ),
    Question(
        name="failures-a-day",
        text=(
            "A receiver gives one fix a second. A fixed failure rate test lets 0.1 % of all epochs be fixed wrong. "
            "How many wrong fixes are that in a day?"
        ),
        answer=86.4,
        tolerance=0.6,
        unit="",
        hints=("How many seconds has a day?", "A thousandth of 86 400."),
        solution=(
            r"$0.001 \cdot 86\,400 = 86.4$." "\n\n"
            "They seldom come singly: reflections last for minutes, and so do the wrong fixes they make. A failure rate is for independent epochs "
            "and a model that is right."
        ),
        mistakes=(
            UsualMistake(864.0, "That is one per cent."),
            UsualMistake(3.6, "That is an hour."),
            UsualMistake(86400.0, "That is all epochs of a day."),
            UsualMistake(0.001, "That is the rate itself. Multiply by the epochs of a day."),
        ),
    ),
    Question(
        name="error-of-a-count",
        text="In 3000 simulated epochs 31.6 % of the fixes were right. What is the standard deviation of this count, in per cent of the epochs?",
        answer=0.8488,
        tolerance=0.01,
        unit="%",
        hints=(
            "Each epoch is right or wrong, with the same chance: a coin that is not fair. What is the variance of one toss?",
            r"$\sqrt{p\,(1 - p) / N}$, with $p = 0.316$ and $N = 3000$.",
        ),
        solution=(
            r"$\sqrt{0.316 \cdot 0.684 / 3000} = 0.0085$, so 31.6 ± 0.85 %." "\n\n"
            "A count of 316 in 1000 would be good to 1.5 %. To halve the error, count four times as many."
        ),
        mistakes=(
            UsualMistake(0.0085, "That is the share of one. In per cent it is a hundred times that."),
            UsualMistake(46.49, "That is the standard deviation of a single epoch. The mean of 3000 has less, by the root of 3000."),
            UsualMistake(1.0263, r"You left out $1 - p$. Where nearly all are right, the count is nearly sure as well."),
            UsualMistake(1.8257, r"That is $1/\sqrt{N}$, twice the largest error that there can be."),
        ),
    ),
    Question(
        name="odds-of-a-ratio-of-ten",
        text=(
            "In the epoch of the scene the best integers have the squared distance 0.010 and the second best 0.104. The ratio is 10. "
            "How many times as probable as the second best are the best?"
        ),
        answer=1.0481,
        tolerance=0.003,
        unit="",
        hints=(
            r"How probable an integer vector is goes with $\exp(-q/2)$, where $q$ is its squared distance.",
            r"$\exp(-0.010/2)$ against $\exp(-0.104/2)$: only the difference of the two counts.",
        ),
        solution=(
            r"$\exp\frac{0.104 - 0.010}{2} = \exp 0.047 = 1.048$: as good as even." "\n\n"
            "Both fit better than the true ones usually do: among many vectors some come close by chance. "
            "In a model with ten ambiguities the true ones have about 10. If the second best have 100, the odds are astronomical, at the same ratio."
        ),
        mistakes=(
            UsualMistake(10.0, "That is the ratio. Probabilities go with the difference of the squared distances, not with their ratio."),
            UsualMistake(1.0986, r"You left out the half: $\exp(-q/2)$."),
            UsualMistake(3.1623, "That is the root of the ratio: of the distances, not of the probabilities."),
            UsualMistake(0.9541, "The other way round: that is the second best against the best."),
        ),
    ),
    Question(
        name="wrong-of-those-believed",
        text=(
            "In the first lab with five satellites and a ratio of 3, 15.5 % of all epochs are fixed, and 14.4 % of all epochs are fixed wrong. "
            "Of the fixes that you believe, how many are wrong?"
        ),
        answer=92.9,
        tolerance=0.5,
        unit="%",
        hints=("The failure rate counts all epochs, but you only see those that were fixed.", "14.4 of every 15.5."),
        solution=(
            r"$14.4 / 15.5 = 0.929$: 92.9 % of what you believe is wrong." "\n\n"
            "A failure rate is a share of all epochs. Before you call it small, look at how many were fixed at all."
        ),
        mistakes=(
            UsualMistake(14.4, "That is the share of all epochs. You believe only 15.5 % of them."),
            UsualMistake(7.1, "That is the share that is right."),
            UsualMistake(1.1, "That is the share of all epochs that is fixed and right."),
        ),
    ),
    Question(
        name="best-equivariant-of-one",
        text=r"One ambiguity: float value $\hat a = 0.40$ cycles, sigma 0.30 cycles. What is the best integer equivariant estimate?",
        answer=0.2476,
        tolerance=0.004,
        unit="cycles",
        hints=(
            r"It is the mean of all integers, each with the weight $\exp(-(\hat a - a)^2 / (2 \sigma^2))$. Only 0 and 1 matter.",
            r"The weight of 0 is $\exp(-0.16/0.18) = 0.411$, that of 1 is $\exp(-0.36/0.18) = 0.135$.",
        ),
        solution=(
            r"$\dfrac{0 \cdot 0.411 + 1 \cdot 0.135}{0.411 + 0.135} = 0.248$." "\n\n"
            "Float says 0.40, rounding says 0. The estimate lies between them, and nearer to the integer that is more probable."
        ),
        mistakes=(
            UsualMistake(0.0, "That is rounding: it gives all weight to the nearest integer."),
            UsualMistake(0.4, "That is the float value: it forgets that the truth is an integer."),
            UsualMistake(0.0978, r"You left out the half: the exponent is $-(\hat a - a)^2 / (2\sigma^2)$."),
            UsualMistake(0.7524, "You gave each integer the other's weight: the nearer one is the more probable."),
        ),
    ),
)  # fmt: skip
