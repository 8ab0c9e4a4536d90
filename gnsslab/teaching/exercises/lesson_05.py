"""Exercises of lesson 05: what a known length does, what a late receiver does, and how a filter is judged."""

from gnsslab.teaching.questions import Prediction, Question, UsualMistake

PREDICTION = Prediction(
    name="what-the-length-improves",
    text=(
        "The roof is level and the whole numbers are known. Now the filter is told that the antennas are 1.167 m apart, to 5 mm. "
        "Which of the two angles becomes better by more than a tenth?"
    ),
    options=("the heading", "the pitch", "both", "neither"),
    answer="neither",
)

QUESTIONS = (
    Question(
        name="a-steep-pitch-as-printed",
        text=(
            "A beam points up by 20°. What pitch does the paper's equation (6) give, "
            r"$\theta = \arcsin\frac{u}{h}$, with the level distance $h = \sqrt{e^2 + n^2}$?"
        ),
        answer=21.3442,
        tolerance=0.01,
        unit="deg",
        hints=(
            r"Take the beam 1 m long: $u = \sin 20°$. And $h$?",
            r"$h = \cos 20°$, so $u/h = \tan 20° = 0.36397$. Take the arcsine of that.",
        ),
        solution=(
            r"$\arcsin(\tan 20°) = 21.344°$: too steep by 1.344°." "\n\n"
            "The error grows with the cube of the pitch: 0.001° at 2°, 0.16° at 10°, 5.3° at 30°. "
            "Above 45° the tangent exceeds 1, and there is no answer. "
            r"Right is $\arctan\frac{u}{h}$, or $\arcsin\frac{u}{\ell}$."
        ),
        mistakes=(
            UsualMistake(20.0, r"That is the true pitch, which $\arctan(u/h)$ gives. The paper printed arcsin."),
            UsualMistake(18.8817, r"You exchanged the two: that is $\arctan(\sin 20°)$."),
            UsualMistake(1.3442, "That is the error. Asked is the pitch that comes out."),
            UsualMistake(0.372527, r"That is in radians. Multiply by $180/\pi$."),
        ),
    ),
    Question(
        name="sigma-of-a-steep-heading",
        text=(
            r"A beam of 1.167 m has a heading of 50° and a pitch of 25°. East, north and up have sigmas of 6, 9 and 16 mm, uncorrelated. "
            r"What is the sigma of the heading, $\sigma_\psi$?"
        ),
        answer=0.42795,
        tolerance=0.003,
        unit="deg",
        hints=(
            r"Across the beam, on the level, points $(\cos\psi,\ -\sin\psi)$ in east and north. What sigma has the baseline in that direction?",
            r"$\sqrt{(\cos 50° \cdot 6)^2 + (\sin 50° \cdot 9)^2} = 7.90$ mm. Divide by the *level* distance, $1.167 \cos 25° = 1.0577$ m.",
        ),
        solution=(
            r"$\sigma_\psi = \dfrac{\sqrt{\cos^2\!\psi\,\sigma_e^2 + \sin^2\!\psi\,\sigma_n^2}}{\ell \cos\theta} "
            r"= \dfrac{7.90\ \text{mm}}{1.0577\ \text{m}} = 0.00747 = 0.428°$." "\n\n"
            "The paper's (33) forgets the square at one of the two sigmas, so its answer depends on the unit: 3.24° in metres."
        ),
        mistakes=(
            UsualMistake(0.387854, r"You divided by the length. The heading turns on the level: divide by $\ell \cos\theta$."),
            UsualMistake(0.400262, r"East and north are exchanged. Across a beam that points north ($\psi = 0$) is east."),
            UsualMistake(0.582412, "You added sigmas. Variances add: square, add, take the root."),
            UsualMistake(0.00746914, r"That is in radians. Multiply by $180/\pi$."),
            UsualMistake(3.238, "That is the formula as printed, with a square missing."),
        ),
    ),
    Question(
        name="sigma-of-a-steep-pitch",
        text=r"The same beam, with the same sigmas: what is the sigma of its pitch, $\sigma_\theta$?",
        answer=0.728266,
        tolerance=0.004,
        unit="deg",
        hints=(
            r"Upwards across the beam points $(-\sin\theta\sin\psi,\ -\sin\theta\cos\psi,\ \cos\theta)$. Three terms, squared and added.",
            r"$\cos 25° \cdot 16 = 14.50$ mm of up, $\sin 25° \cos 50° \cdot 9 = 2.44$ mm of north, $\sin 25° \sin 50° \cdot 6 = 1.94$ mm of east.",
        ),
        solution=(
            r"$\sigma_\theta = \dfrac{1}{\ell}\sqrt{\cos^2\!\theta\,\sigma_u^2 + "
            r"\sin^2\!\theta\,(\cos^2\!\psi\,\sigma_n^2 + \sin^2\!\psi\,\sigma_e^2)} "
            r"= \dfrac{14.83\ \text{mm}}{1167\ \text{mm}} = 0.728°$." "\n\n"
            "Pitch is nearly twice as uncertain as heading. All satellites are above you, so up is the worst of the three."
        ),
        mistakes=(
            UsualMistake(0.711947, r"That is up alone. At a pitch of 25° east and north take part with $\sin\theta$."),
            UsualMistake(0.785546, "That is a level beam. Here up counts with the cosine of the pitch, and east and north take part."),
            UsualMistake(0.803553, r"You divided by $\ell \cos\theta$. That belongs to the heading; the pitch turns the whole length."),
            UsualMistake(0.0127106, r"That is in radians. Multiply by $180/\pi$."),
        ),
    ),
    Question(
        name="a-late-receiver",
        text=(
            "A car drives at 20 m/s. The beam of 1.167 m lies *across* the roof, and one receiver measures 1 ms later than the other. "
            "By how much is the heading off if nobody knows of the delay?"
        ),
        answer=0.981837,
        tolerance=0.01,
        unit="deg",
        hints=(
            "How far does the car drive in 1 ms?",
            "2 cm, at right angles to the beam. Which angle has 2 cm across and 1.167 m along?",
        ),
        solution=(
            r"$\arctan\dfrac{v\,\Delta t}{\ell} = \arctan\dfrac{0.020}{1.167} = 0.98°$." "\n\n"
            "Three times the sigma of the heading, and no average removes it. "
            "With the beam *along* the roof the 2 cm go into the length, and the heading does not notice."
        ),
        mistakes=(
            UsualMistake(0.0171367, r"That is in radians. Multiply by $180/\pi$."),
            UsualMistake(0.4909, "Half of it. Only one antenna is measured late, but it is late by the whole millisecond."),
            UsualMistake(0.272765, "You took the speed for 20 km/h. At 20 m/s the car drives 2 cm in a millisecond."),
            UsualMistake(1.14576, "The car does drive 2 cm. But the beam is 1.167 m long, not 1 m."),
        ),
    ),
    Question(
        name="least-speed",
        text="The same car and beam, 1 ms apart. From what speed on is the heading off by half a degree?",
        answer=10.1843,
        tolerance=0.1,
        unit="m/s",
        hints=(
            "How far must one end move across the beam to turn it by half a degree?",
            r"$1.167 \tan 0.5° = 10.18$ mm, in 1 ms.",
        ),
        solution=(
            r"$v = \dfrac{\ell \tan 0.5°}{\Delta t} = \dfrac{10.18\ \text{mm}}{1\ \text{ms}} = 10.2$ m/s: city traffic." "\n\n"
            "Only the product counts. Where the antennas move at 6 cm/s, as on a slow turntable, it takes 0.17 s."
        ),
        mistakes=(
            UsualMistake(5.0922, "Half of it. The whole shift falls on one antenna."),
            UsualMistake(583.5, "You left the angle in degrees. Half a degree is 0.00873 radians."),
            UsualMistake(36.66, "That is in km/h."),
            UsualMistake(0.0101843, "That is the shift in metres. Divide by the time, 0.001 s."),
        ),
    ),
    Question(
        name="tape-and-prior",
        text=(
            "Before the length comes in, the filter knows the baseline *along* the beam with a sigma of 10 mm. The tape is good to 5 mm. "
            "What is the sigma along the beam afterwards?"
        ),
        answer=4.47214,
        tolerance=0.03,
        unit="mm",
        hints=(
            "Two independent measurements of one length. What adds up?",
            r"One over the variance: $\frac{1}{\sigma^2} = \frac{1}{10^2} + \frac{1}{5^2}$.",
        ),
        solution=(
            r"$\sigma = \left(\dfrac{1}{10^2} + \dfrac{1}{5^2}\right)^{-1/2} = \sqrt{20} = 4.47$ mm." "\n\n"
            "Better than each of the two. Across the beam nothing changes, unless its error is correlated with the one along."
        ),
        mistakes=(
            UsualMistake(20.0, "That is the variance, in mm². Take its root."),
            UsualMistake(11.1803, "Variances add where errors add up. Here are two measurements of one thing: their weights add."),
            UsualMistake(3.3333, "You added one over sigma. It is one over the *variance* that adds."),
            UsualMistake(7.0711, "You took the length and the prior as equally good."),
            UsualMistake(10.0, "That is the row as printed in (16), whose sigma is the length itself. It does nothing."),
        ),
    ),
    Question(
        name="the-row-as-printed",
        text=(
            "As printed, equation (16) gives the length a sigma of 1.167 m. By how many **micrometres** does that row "
            "improve a sigma of 10 mm along the beam?"
        ),
        answer=0.367117,
        tolerance=0.005,
        unit="µm",
        hints=(
            r"The same formula as before, with 1167 mm in place of 5 mm. The result is $10 \cdot \left(1 + (10/1167)^2\right)^{-1/2}$ mm.",
            r"For small $x$, $(1 + x)^{-1/2}$ is $1 - x/2$. Here $x = (10/1167)^2 = 7.34 \cdot 10^{-5}$.",
        ),
        solution=(
            r"$10\ \text{mm} \cdot \dfrac{7.34 \cdot 10^{-5}}{2} = 0.00037$ mm $= 0.37$ µm." "\n\n"
            "A two-hundredth of a hair. Results that got better after this row was added did so for another reason."
        ),
        mistakes=(
            UsualMistake(0.734, "Twice too much: the root halves a small change."),
            UsualMistake(0.000367, "That is in millimetres."),
            UsualMistake(42.66, r"You did not square 10/1167. Weights go with one over the *variance*."),
            UsualMistake(5527.9, "That is the tape of 5 mm, the row as it was meant."),
        ),
    ),
    Question(
        name="a-shorter-beam",
        text="On a beam of 1.167 m the heading has a sigma of 0.40°. What is it on a drone, with 0.30 m and the same antennas?",
        answer=1.556,
        tolerance=0.01,
        unit="deg",
        hints=("The error across the beam, in millimetres, stays the same.", r"Sigma goes as $1/\ell$. How many times shorter is the beam?"),
        solution=(
            r"$0.40° \cdot \dfrac{1.167}{0.30} = 1.56°$." "\n\n"
            "The antennas do not know how far apart they are. What is lost in precision is won in the search: a small sphere holds few candidates."
        ),
        mistakes=(
            UsualMistake(0.102828, "The other way round: a shorter beam points worse."),
            UsualMistake(6.0528, "You squared it. Sigma goes as one over the length, the variance as one over its square."),
            UsualMistake(0.788923, "You took the root. It is sigma that goes as one over the length, not the variance."),
            UsualMistake(0.40, "The millimetres stay the same. The angle is millimetres over the length."),
        ),
    ),
    Question(
        name="bound-of-the-mean",
        text=(
            "A filter takes in 13 double differences at each epoch. Over 100 epochs you take the mean of its NIS. "
            "If all is well, in 19 of 20 runs this mean lies between two bounds. What is the upper one?"
        ),
        answer=14.0,
        tolerance=0.06,
        unit="",
        hints=(
            "NIS of one epoch is chi-square with 13 degrees of freedom: mean 13, variance 26. What is the sigma of the mean of 100?",
            r"$\sqrt{26/100} = 0.51$. Nineteen of twenty lie within 1.96 sigma.",
        ),
        solution=(
            r"$13 + 1.96 \sqrt{\dfrac{2 \cdot 13}{100}} = 13 + 1.0 = 14.0$." "\n\n"
            "The exact bounds, of chi-square with 1300 degrees of freedom, are 12.02 and 14.02. "
            "For a single epoch they are 5.0 and 24.7: one epoch says little, a hundred say much."
        ),
        mistakes=(
            UsualMistake(24.7356, "That is the bound for one epoch. The mean of 100 scatters ten times less."),
            UsualMistake(13.51, "That is one sigma. Nineteen of twenty lie within 1.96."),
            UsualMistake(13.7067, r"You took 13 for the variance. That of chi-square is *twice* its degrees of freedom."),
            UsualMistake(13.8387, "That leaves a twentieth above. A twentieth on both sides together needs 1.96, not 1.64."),
        ),
    ),
    Question(
        name="what-the-mean-says",
        text=(
            "The mean NIS of the carrier is 5.2, where 13 are expected. By what factor are the filter's sigmas of the carrier too large, "
            "if everything else is right?"
        ),
        answer=1.58114,
        tolerance=0.01,
        unit="",
        hints=(
            "NIS is innovation *squared* over the variance that the filter expects.",
            r"The variances are too large by $13/5.2 = 2.5$.",
        ),
        solution=(
            r"$\sqrt{13/5.2} = \sqrt{2.5} = 1.58$." "\n\n"
            "Beware of *if everything else is right*. Here the sigmas were made too large on purpose: "
            "they also stand for reflections, which last for a minute "
            "and look small from one second to the next."
        ),
        mistakes=(
            UsualMistake(2.5, "That is the factor of the variances. Sigma is the root."),
            UsualMistake(0.632456, "The other way round: a NIS that is too small means sigmas that are too large."),
            UsualMistake(0.4, "NIS over its mean. Turn it round, and take the root."),
            UsualMistake(6.25, "You squared the factor of the variances. Sigma is their root."),
        ),
    ),
    Question(
        name="ratio-with-the-length",
        text=(
            "Two vectors of whole numbers are in the running. The first has the squared distance 4.0 and a baseline of 1.180 m, "
            "the second 6.0 and 1.168 m. "
            "The antennas are 1.167 m apart, and a length is good to 5 mm, tape and carrier together. "
            "What is the ratio of second best to best, *with* the length?"
        ),
        answer=1.78146,
        tolerance=0.01,
        unit="",
        hints=(
            r"To each squared distance add $\left(\frac{\text{its length} - 1.167\ \text{m}}{5\ \text{mm}}\right)^2$. Which one is best then?",
            r"$4.0 + 2.6^2 = 10.76$ and $6.0 + 0.2^2 = 6.04$.",
        ),
        solution=(
            r"$\dfrac{10.76}{6.04} = 1.78$, and the *second* vector is the best." "\n\n"
            "Without the length the first one leads, with a ratio of 1.5. The length has turned the order round. "
            "A ratio of 3 it has not given: this epoch stays float."
        ),
        mistakes=(
            UsualMistake(1.5, "That is without the length. Each baseline has a length of its own: what does it cost?"),
            UsualMistake(0.561338, "Upside down: the best is the one with the smaller cost, 6.04."),
            UsualMistake(1.06452, "You did not square the difference of the lengths over its sigma."),
            UsualMistake(169.0, "That is the cost of the lengths alone, squared, one over the other. Add each to its squared distance first."),
        ),
    ),
    Question(
        name="heading-rate",
        text=(
            "A heading has a noise of 0.20° that is new at each epoch, and an error of 0.30° by reflections that hardly changes within a second. "
            "You take two headings, a second apart. What is the sigma of the heading *rate*?"
        ),
        answer=0.282843,
        tolerance=0.004,
        unit="deg/s",
        hints=(
            "The rate is the difference of the two. What is the same in both is gone, as in lesson 02.",
            r"Two independent noises of 0.20° each: $\sqrt{2} \cdot 0.20°$.",
        ),
        solution=(
            r"$\sqrt{0.20^2 + 0.20^2} = 0.28$ deg/s." "\n\n"
            "Two epochs ten seconds apart give 0.028 deg/s, if the reflections still are the same then."
        ),
        mistakes=(
            UsualMistake(0.509902, "You took the reflections for noise. They are the same in both headings, and cancel."),
            UsualMistake(0.2, "That is one of the two headings. Both are noisy."),
            UsualMistake(0.4, "You added sigmas. Variances add."),
            UsualMistake(0.360555, "That is one heading, noise and reflections. The rate takes two, and what both share cancels."),
        ),
    ),
)  # fmt: skip
