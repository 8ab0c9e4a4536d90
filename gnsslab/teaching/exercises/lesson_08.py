"""Exercises of lesson 08: whom to believe when two numbers disagree, what a filter does to a step, and what an alarm costs."""

from gnsslab.teaching.questions import Prediction, Question, UsualMistake

PREDICTION = Prediction(
    name="which-step-is-seen-sooner",
    text=(
        "A filter follows a slope, one position every 15 seconds. It throws out what does not fit, because wrong fixes do not fit. "
        "One night the slope jumps, once and for all. Which jump has the filter followed half of the way *sooner*?"
    ),
    options=("a jump of 3.6 cm", "a jump of 15 cm", "both after the same time"),
    answer="a jump of 3.6 cm",
)

QUESTIONS = (
    Question(
        name="two-numbers-that-disagree",
        text=(
            "The mean of the last half hour says that the baseline is 120.0 cm long, with a sigma of 1.5 cm. The epoch of now says 124.0 cm, "
            "with a sigma of 3.0 cm. What is the best value for both together?"
        ),
        answer=120.8,
        tolerance=0.04,
        unit="cm",
        hints=(
            "The weighted mean. Each number counts with one over its *variance*.",
            r"The new one gets the weight $w = \dfrac{1.5^2}{1.5^2 + 3.0^2} = 0.2$, the old one the rest.",
        ),
        solution=(
            r"$0.8 \cdot 120.0 + 0.2 \cdot 124.0 = 120.8$ cm." "\n\n"
            "The old number is twice as sharp, so it counts four times as much. "
            'The "improved unconstrained adjustment" of the paper gives this value, and nothing else.'
        ),
        mistakes=(
            UsualMistake(122.0, "That is the plain mean. The two are not equally good."),
            UsualMistake(121.3333, "You weighed with one over sigma. It is one over the variance."),
            UsualMistake(123.2, "You exchanged the weights. The *sharper* number counts more."),
            UsualMistake(124.0, "That is the new number alone. Half an hour of measurements is worth something."),
        ),
    ),
    Question(
        name="sigma-of-both-together",
        text="And the sigma of that best value, if the two errors are independent?",
        answer=1.341641,
        tolerance=0.01,
        unit="cm",
        hints=(
            "Weights add: one over the variance of both together is the sum of both.",
            r"$\dfrac{1}{\sigma^2} = \dfrac{1}{1.5^2} + \dfrac{1}{3.0^2} = 0.5556$.",
        ),
        solution=(
            r"$\sigma = 1/\sqrt{0.5556} = 1.34$ cm: a little better than the better of the two." "\n\n"
            r"Beware of *independent*. If reflections last for minutes, the epoch of now and the mean before it share an error, and "
            r"the gain is smaller."
        ),
        mistakes=(
            UsualMistake(1.8, "That is the variance, in cm². Take its root."),
            UsualMistake(3.3541, "You added the variances. That is the sigma of the *difference* of the two."),
            UsualMistake(1.6771, "That is the sigma of the plain mean. It is worse than the better of the two numbers."),
            UsualMistake(1.0, r"You added one over sigma. It is one over the variance that adds."),
        ),
    ),
    Question(
        name="rank-of-the-normal-matrix",
        text=(
            r"Equation (12) of the paper inverts $A^\top P A$ with $A = [-I\ \ I]$: three conditions for six unknowns, the "
            r"corrections of two positions. "
            "What is the rank of this 6 by 6 matrix?"
        ),
        answer=3.0,
        tolerance=0.1,
        unit="",
        hints=(
            "How many rows does $A$ have?",
            "Move both positions by the same metre. Does any of the three conditions notice?",
        ),
        solution=(
            "The rank is **3**. No product has a higher rank than its smallest factor, and $A$ has three rows." "\n\n"
            "So there is no inverse. The equations say how far the two positions must come *together*, and nothing about where. Ask for the smallest "
            "corrections besides, and there is one answer: the weighted mean."
        ),
        mistakes=(
            UsualMistake(6.0, "Then it could be inverted. But moving both positions together changes nothing: some directions have no information."),
            UsualMistake(2.0, "Two positions, but three conditions: one for each axis."),
            UsualMistake(1.0, "One condition for each axis, and there are three axes."),
        ),
    ),
    Question(
        name="what-is-left-of-a-doubtful-epoch",
        text=(
            "IGG3 with $k_0 = 1$ and $k_1 = 2$. An epoch's innovation is 1.5 of its sigmas. "
            r"By what factor $\lambda$ does the filter enlarge the *variance* of this epoch?"
        ),
        answer=6.0,
        tolerance=0.05,
        unit="",
        hints=(
            r"Between the thresholds $\eta = \dfrac{k_0}{|v|}\left(\dfrac{k_1 - |v|}{k_1 - k_0}\right)^2$.",
            r"$\eta = \dfrac{1}{1.5} \cdot 0.5^2 = \dfrac16$, and $\lambda = 1/\eta$.",
        ),
        solution=(
            r"$\lambda = 6$: its sigma counts as $\sqrt6 = 2.4$ times as large." "\n\n"
            "Of the good epochs 13 % are that far off or farther. This filter is deaf to much that is true."
        ),
        mistakes=(
            UsualMistake(0.1667, r"That is the weight $\eta$. The variance grows by one over it."),
            UsualMistake(2.4495, "That is the factor of the sigma. Asked is that of the variance."),
            UsualMistake(3.0, "You forgot the square of the fraction."),
            UsualMistake(4.0, r"You forgot the first factor, $k_0/|v| = 1/1.5$."),
            UsualMistake(1.5, r"That is one over the first factor. The fraction, squared, is missing."),
        ),
    ),
    Question(
        name="good-epochs-thrown-out",
        text=(
            "All is well: the errors are normal, and the filter knows their sigma. It rejects each innovation beyond $k_1 = 2.5$ sigma. "
            "What share of the good epochs does it throw out?"
        ),
        answer=1.241933,
        tolerance=0.02,
        unit="%",
        hints=(
            "How often does a normal number lie within two and a half sigma?",
            "In 98.76 % of all cases. On both sides together the rest is outside.",
        ),
        solution=(
            "1.24 %, one epoch in 81. With the paper's $k_1 = 2$ it is 4.55 %, one epoch in 22." "\n\n"
            "Gross errors are three in a thousand in the paper's series. So for every wrong fix its filter throws out fourteen good ones."
        ),
        mistakes=(
            UsualMistake(0.620967, "That is one side. Innovations may be too large in both directions."),
            UsualMistake(4.55003, "That is beyond *two* sigma, the paper's $k_1$."),
            UsualMistake(98.7581, "That is the share that is kept."),
            UsualMistake(0.01241933, "That is a share. In per cent it is a hundred times as much."),
        ),
    ),
    Question(
        name="gain-when-all-has-settled",
        text=(
            "A Kalman filter follows a random walk. The walk's variance grows by $q = 0.48$ cm² an epoch, a measurement has $r = 9.9$ cm². "
            "What is the gain $K$ once all has settled?"
        ),
        answer=0.197281,
        tolerance=0.001,
        unit="",
        hints=(
            r"Settled means: what the measurement takes from $P$, the walk gives back. With $P$ *before* a measurement, "
            r"$P = \dfrac{P\,r}{P + r} + q$.",
            r"So $P^2 - qP - qr = 0$ and $P = \dfrac{q + \sqrt{q^2 + 4qr}}{2} = 2.433$ cm².",
        ),
        solution=(
            r"$K = \dfrac{P}{P + r} = \dfrac{2.433}{2.433 + 9.9} = 0.197$: a fifth of each innovation is believed." "\n\n"
            "Only $q/r$ counts. A hundred times smaller, and the gain falls to 0.022: a third of the scatter, and nine times as slow."
        ),
        mistakes=(
            UsualMistake(0.046243, r"That is $q/(q + r)$. $P$ is more than one step of the walk: it has gathered many."),
            UsualMistake(0.16477, "You took $P$ after the measurement, 1.953 cm². The gain needs the one before."),
            UsualMistake(0.802719, "That is what remains of the old level, $1 - K$."),
            UsualMistake(0.220194, r"That is $\sqrt{q/r}$, where it tends for a small $q$. Here $q$ is not small enough."),
        ),
    ),
    Question(
        name="a-small-step-through-the-filter",
        text=(
            "The same filter, settled, rejects nothing, and there is no noise. The slope goes by 1 cm at once. The epoch at which it "
            "does is the first to show it. "
            "With which epoch, counted from that one as number 1, has the filter followed 90 % or more of it?"
        ),
        answer=11.0,
        tolerance=0.4,
        unit="",
        hints=(
            "Each epoch takes a share $K = 0.197$ off what is still missing.",
            r"After $n$ epochs $0.803^n$ is missing. When is that a tenth or less?",
        ),
        solution=(
            r"$n = \dfrac{\ln 0.1}{\ln 0.803} = 10.5$, so with epoch **11**. At 15 s an epoch these are 2.5 minutes." "\n\n"
            "With the adjustment before it, the paper's own method, it takes about five times as long. It is *not* as fast as the raw series."
        ),
        mistakes=(
            UsualMistake(10.0, "With epoch 10 it has followed 88.9 %."),
            UsualMistake(5.0, "You took the gains as adding up, 5 times 0.197. But each is a share of what is *still* missing."),
            UsualMistake(4.0, "That is for half of the step. Asked are nine tenths."),
            UsualMistake(1.0, "With one epoch it has followed a fifth."),
        ),
    ),
    Question(
        name="a-step-too-large",
        text=(
            "The same filter with IGG3, but milder than the paper's: $k_0 = 1.5$ and $k_1 = 3$. It has settled at $P = 2.433$ cm² "
            "before a measurement, "
            "and $r = 9.9$ cm². From what size on does it reject a step altogether?"
        ),
        answer=10.53555,
        tolerance=0.04,
        unit="cm",
        hints=(
            r"The innovation is judged by its own sigma, $\sqrt{S}$ with $S = P + r$.",
            r"$\sqrt{12.33} = 3.51$ cm, and it is rejected from $k_1 = 3$ of them on.",
        ),
        solution=(
            r"$3\sqrt{2.433 + 9.9} = 10.5$ cm. With the paper's $k_1 = 2$ it is 7.0 cm." "\n\n"
            "Below, the filter follows, slowly at first. Above, it takes the truth for a wrong fix and stays where it was. "
            "Milder thresholds move the limit. They do not remove it."
        ),
        mistakes=(
            UsualMistake(9.43928, r"That is $3\sqrt{r}$. The prediction is uncertain too: $S = P + r$."),
            UsualMistake(7.0237, r"That is with the paper's $k_1 = 2$."),
            UsualMistake(5.26777, r"That is $k_0$, where the weight begins to fall. It is zero from $k_1$ on."),
            UsualMistake(36.9992, "That is three times the variance. Take the root first."),
            UsualMistake(10.32849, r"You took $P$ after the measurement, 1.953 cm². The innovation comes before."),
        ),
    ),
    Question(
        name="how-long-it-stays-blind",
        text=(
            "The paper's filter again, $k_1 = 2$. The slope goes by 12 cm at once; nothing else moves, and there is no noise. "
            "While it rejects, the filter "
            "becomes less sure of itself: from 2.433 cm² on, $P$ grows by $q = 0.48$ cm² each epoch. How many epochs does it "
            "reject before it takes in the first one?"
        ),
        answer=50.0,
        tolerance=0.4,
        unit="",
        hints=(
            r"It takes an epoch in as soon as 12 cm are less than $2\sqrt{P + r}$. What must $P$ be?",
            r"$P > 6^2 - 9.9 = 26.1$ cm². It starts from 2.433 and gains 0.48 with each epoch: $23.67/0.48 = 49.3$.",
        ),
        solution=(
            "The epochs 0 to 49 after the step are rejected: **50**. At 15 s that is more than twelve minutes in which the alarm system is blind, "
            "and even then the first ones count for next to nothing." "\n\n"
            "For 10 cm it rejects 27 epochs, for 15 cm 92. Time grows with the *square* of the step."
        ),
        mistakes=(
            UsualMistake(49.0, "You rounded down. After so many steps of the walk it still rejects, and epoch 0 counts too."),
            UsualMistake(275.0, "You compared with one sigma. It rejects from two on."),
            UsualMistake(92.0, "That is for a step of 15 cm."),
            UsualMistake(70.0, "You forgot $r$: $P + r$ must reach 36 cm², not $P$ alone."),
        ),
    ),
    Question(
        name="two-methods-against-one",
        text=(
            "One method leaves a scatter of 1.40 cm, two together 1.00 cm. The raw series has 2.37 cm. The paper says that "
            "both are better than the one by 16.7 %. By how many per cent is 1.00 cm really less than 1.40 cm?"
        ),
        answer=28.5714,
        tolerance=0.1,
        unit="%",
        hints=(
            "Less than what? The whole is 1.40 cm.",
            r"$\dfrac{1.40 - 1.00}{1.40}$.",
        ),
        solution=(
            r"$0.40/1.40 = 28.6\ \%$." "\n\n"
            "The paper subtracted two gains over the raw series, 57.6 % less 40.9 %. That makes 16.7 percentage *points*. "
            "Here the author sold himself short. Mostly it goes the other way."
        ),
        mistakes=(
            UsualMistake(16.7, "That is the difference of two percentages of the raw series: percentage points."),
            UsualMistake(40.0, "You divided by 1.00. Less *than 1.40*: that is the whole."),
            UsualMistake(16.8776, "You divided by the raw 2.37 cm. That is the difference of two gains, in percentage points."),
            UsualMistake(57.8, "That is the gain of both over the raw series."),
        ),
    ),
    Question(
        name="alarms-of-a-quiet-day",
        text=(
            "A point on the slope gives an epoch every 15 s. One axis is watched, the errors are normal and independent from epoch to epoch, "
            "and an alarm goes off whenever an epoch is more than 3 sigma off. How many false alarms are there in a day?"
        ),
        answer=15.5508,
        tolerance=0.2,
        unit="",
        hints=(
            "How many epochs has a day, and what share of normal numbers lies beyond 3 sigma?",
            "5760 epochs, and 0.27 % of them.",
        ),
        solution=(
            "$5760 \\cdot 0.0027 = 15.6$. After the first night nobody gets up any more." "\n\n"
            "For one false alarm in a *month* the threshold must be 4.53 sigma. That sounds close. But a step must now be half as large again "
            "before a single epoch shows it. It is better to wait for a few epochs."
        ),
        mistakes=(
            UsualMistake(7.7754, "That is one side. The slope does not move up, but errors do."),
            UsualMistake(0.3649, "That is for 4 sigma."),
            UsualMistake(0.0027, "That is the share of the epochs. A day has 5760 of them."),
            UsualMistake(233.3, "That is with an epoch a second. Here there is one every 15."),
        ),
    ),
    Question(
        name="how-many-epochs-must-agree",
        text=(
            "You know the old level. The noise is white with a sigma of 2.0 cm, and the slope has gone by 3.6 cm. "
            "How many epochs do you need until the mean of them is 5 of its own sigmas off, on average?"
        ),
        answer=8.0,
        tolerance=0.4,
        unit="",
        hints=(
            r"The mean of $n$ independent epochs has the sigma $2.0/\sqrt n$ cm.",
            r"$3.6 \sqrt n / 2.0 \ge 5$. What is $n$?",
        ),
        solution=(
            r"$n \ge (5 \cdot 2.0/3.6)^2 = 7.7$: **8** epochs." "\n\n"
            "No test can do much better at so few false alarms. That is what a step costs: you may wait, or be woken for nothing. "
            "For 10 cm a single epoch is enough, but then you cannot tell it from a wrong fix."
        ),
        mistakes=(
            UsualMistake(2.7778, "Square it: the sigma of a mean falls with the *root* of the number."),
            UsualMistake(1.0, "One epoch is off by 1.8 sigma. In a day of 5760 epochs, 400 are that far off for nothing."),
            UsualMistake(5.0, "Five epochs give 4 sigma: $1.8 \\sqrt 5$."),
            UsualMistake(3.0, "Three epochs give 3.1 sigma. Asked are five."),
        ),
    ),
    Question(
        name="a-minute-of-reflections",
        text=(
            "The error of a series at 1 Hz is 1.0 cm, and it is all reflections: the correlation between two epochs $t$ seconds apart is "
            r"$e^{-t/\tau}$ with $\tau = 110$ s. What is the sigma of the mean of 60 epochs?"
        ),
        answer=0.916811,
        tolerance=0.01,
        unit="cm",
        hints=(
            "If the epochs were independent, it would be $1/\\sqrt{60} = 0.13$ cm. But a minute is shorter than these errors last.",
            r"The variance of the mean is the mean over all pairs of epochs of their correlation. Sixty seconds apart it is still 0.58; "
            r"for the mean over all pairs take $\frac{2}{x^2}\,(x - 1 + e^{-x})$ with $x = 60/110$.",
        ),
        solution=(
            "0.92 cm: seven times more than the root of 60 promises. A minute of waiting has bought 8 %." "\n\n"
            r"To halve the error takes twelve and a half minutes. For long means the variance falls as $2\tau/t$: "
            "an independent epoch every 220 s, however often you measure."
        ),
        mistakes=(
            UsualMistake(0.129099, "That is for independent errors. These last for two minutes."),
            UsualMistake(0.840543, "That is the variance, in cm². Take its root."),
            UsualMistake(1.0, "Nearly. But a minute is not nothing: the first and the last epoch have a correlation of 0.58."),
            UsualMistake(0.579578, "That is the correlation of the first and the last epoch."),
        ),
    ),
    Question(
        name="a-length-that-looks-away",
        text=(
            "A baseline is 1.20 m long and level. The rover is moved 2 cm to the west and 3 cm to the south: 3.6 cm. The baseline "
            "points at right angles to that, "
            "to the south-east. By how much does its *length* change?"
        ),
        answer=0.541545,
        tolerance=0.01,
        unit="mm",
        hints=(
            "Draw it: a right angle between the baseline and the motion. Pythagoras.",
            r"$\sqrt{1200^2 + 36.06^2} - 1200$ mm, or nearly $\dfrac{36.06^2}{2 \cdot 1200}$.",
        ),
        solution=(
            "0.54 mm. The slope has gone by 3.6 cm, and the length has hardly noticed." "\n\n"
            "The paper judges by the length alone. It changes by 3.6 cm only if the baseline points along the motion, to the "
            "south-west or the north-east. "
            "Watch east, north and up, not the length."
        ),
        mistakes=(
            UsualMistake(36.0555, "That is how far the rover has moved. The length tells only the part along the baseline."),
            UsualMistake(1.08333, "Twice too much: the root halves a small square."),
            UsualMistake(0.0541545, "That is in centimetres."),
            UsualMistake(50.0, "You added west and south. They are at right angles to each other: 3.6 cm."),
        ),
    ),
)  # fmt: skip
