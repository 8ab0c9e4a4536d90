"""Exercises of lesson 01: what code, carrier and Doppler say, in metres."""

from gnsslab.teaching.questions import Prediction, Question, UsualMistake

PREDICTION = Prediction(
    name="how-much-finer",
    text="The receiver measures the way to the satellite twice: by the code, and by the carrier wave. How much finer is the carrier?",
    options=("not at all", "about 10 times", "100 times or more", "a million times"),
    answer="100 times or more",
)

QUESTIONS = (
    Question(
        name="slip-in-metres",
        text=(
            r"A receiver loses lock for a moment. From then on its carrier counts 7 cycles too many on L1, $\lambda = 0.1903$ m. "
            r"By how much does code minus carrier, $P - \Phi$, move? Mind the sign."
        ),
        answer=-1.332056,
        tolerance=0.01,
        unit="m",
        hints=(
            r"Turn the cycles into metres first: $\Phi = \lambda\phi$.",
            r"The carrier grows by $7\lambda$. It stands with a minus in $P - \Phi$.",
        ),
        solution=(
            r"$P - \Phi$ moves by $-7 \cdot 0.1903 = -1.33$ m. The code knows nothing of it." "\n\n"
            "In a code that scatters by 0.4 m you see that step. A step of one cycle you do not see: it needs the carrier of a second frequency."
        ),
        mistakes=(
            UsualMistake(1.332056, r"The size is right. But the carrier has a minus sign in $P - \Phi$."),
            UsualMistake(-7.0, r"That is in cycles. Multiply by the wavelength to get metres."),
            UsualMistake(7.0, r"That is in cycles. Multiply by the wavelength, and mind the sign of $\Phi$ in $P - \Phi$."),
            UsualMistake(-1.709471, r"You took the wavelength of L2, 0.2442 m. The slip is on L1."),
            UsualMistake(-36.785, r"You divided by the wavelength. A cycle is $\lambda$ long: multiply."),
        ),
    ),
    Question(
        name="ionosphere-from-code-minus-carrier",
        text=(
            "In ten minutes the mean of code minus carrier climbs by 3.4 m. There was no slip. By how much has the ionospheric delay $I$ grown?"
        ),
        answer=1.7,
        tolerance=0.02,
        unit="m",
        hints=(
            r"Write $P$ and $\Phi$ below each other and subtract. Which terms stay?",
            r"$P - \Phi = 2I - \lambda N$: the ionosphere delays the code and advances the carrier.",
        ),
        solution=(
            r"$P - \Phi = 2I - \lambda N$, and $\lambda N$ is constant. So $2\,\Delta I = 3.4$ m and $\Delta I = 1.7$ m." "\n\n"
            "Clocks, distance and troposphere are the same in both and cancel. Nothing else can climb like that."
        ),
        mistakes=(
            UsualMistake(3.4, "That is twice the ionosphere: it is plus in the code and minus in the carrier."),
            UsualMistake(6.8, "You doubled. What you see is twice the delay already, so halve it."),
            UsualMistake(-1.7, "The size is right. But the code is late, so a larger delay makes $P$ larger: the delay has grown."),
        ),
    ),
    Question(
        name="microseconds-of-light",
        text="A receiver's clock is fast by 2.0 microseconds. By how much is the code $P$ of every satellite too long?",
        answer=599.584916,
        tolerance=1.0,
        unit="m",
        hints=(
            r"The term is $c\,dt_r$, with $c = 299\,792\,458$ m/s.",
            r"Light goes 300 m in a microsecond.",
        ),
        solution=(
            r"$c\,dt_r = 299\,792\,458 \cdot 2.0 \cdot 10^{-6} = 599.6$ m, the same for every satellite." "\n\n"
            "That is why a fourth satellite is needed: it finds the clock. In $P - \\Phi$ the clock cancels."
        ),
        mistakes=(
            UsualMistake(0.0, r"The clock cancels in $P - \Phi$. In the code alone it does not."),
            UsualMistake(599584.916, "That is for 2 milliseconds. A microsecond is a millionth of a second."),
            UsualMistake(0.599585, "That is for 2 nanoseconds. A microsecond is a millionth of a second."),
            UsualMistake(-599.584916, "The size is right. A fast clock reads a later time of arrival, so the way seems longer."),
            UsualMistake(299.792458, "That is for one microsecond."),
        ),
    ),
    Question(
        name="speed-from-doppler",
        text=r"The Doppler $D$ of a satellite on L1 ($\lambda = 0.1903$ m) is +2100 Hz. How fast does the measured distance change? Mind the sign.",
        answer=-399.6167,
        tolerance=1.0,
        unit="m/s",
        hints=(
            r"One wave more a second brings the satellite nearer by one wavelength a second.",
            r"$D = -\dot\Phi/\lambda$, so the rate is $\dot\Phi = -\lambda D$.",
        ),
        solution=(
            r"$\dot\Phi = -\lambda D = -0.1903 \cdot 2100 = -399.6$ m/s: the satellite comes nearer." "\n\n"
            "The receiver's clock is in that number too. A clock that gains 100 ns a second adds 30 m/s, for every satellite alike."
        ),
        mistakes=(
            UsualMistake(399.6167, "The size is right. A positive Doppler means that the satellite comes nearer: the distance shrinks."),
            UsualMistake(-2100.0, "That is in cycles a second. Multiply by the wavelength."),
            UsualMistake(2100.0, "That is in cycles a second. Multiply by the wavelength, and mind the sign."),
            UsualMistake(-11035.3, "You divided by the wavelength. A cycle is $\\lambda$ long: multiply."),
        ),
    ),
    Question(
        name="sigma-of-a-low-satellite",
        text=(
            r"The white noise of a code has $\sigma = 0.30$ m at the zenith. It grows as $\sqrt{\frac12 + \frac{1}{2\sin^2\mathrm{el}}}$. "
            "What is it for a satellite 10 deg above the horizon?"
        ),
        answer=1.239917,
        tolerance=0.02,
        unit="m",
        hints=(
            r"$\sin 10° = 0.1736$. Check that your calculator works in degrees.",
            r"$\frac12 + \frac{1}{2 \cdot 0.03015} = 17.08$. Take the root, then multiply by 0.30 m.",
        ),
        solution=(
            r"$\sqrt{17.08} = 4.133$, and $4.133 \cdot 0.30 = 1.24$ m." "\n\n"
            "The signal comes through more air, from the weak edge of the antenna, and past more obstacles. Four times the noise is mild."
        ),
        mistakes=(
            UsualMistake(5.1246, "You forgot the root. Under it stands a growth of the variance, not of sigma."),
            UsualMistake(1.727631, r"You took $1/\sin\mathrm{el}$. That is the law of multipath, not that of white noise."),
            UsualMistake(0.44391, "Your calculator took 10 as radians. Switch it to degrees."),
        ),
    ),
    Question(
        name="mean-of-a-hundred",
        text="White code noise, $\\sigma = 0.60$ m. You take the mean of 100 readings. What is the standard deviation of the mean?",
        answer=0.06,
        tolerance=0.001,
        unit="m",
        hints=(
            "The *variance* of the mean is the variance of one reading divided by the number of readings.",
            r"So sigma is divided by the root of it, $\sqrt{100}$.",
        ),
        solution=(
            r"$0.60 / \sqrt{100} = 0.06$ m. After a hundred readings the code is still thirty times coarser than one of the carrier." "\n\n"
            "And this holds for white noise only. Multipath lasts for half a minute, so a hundred seconds of it are worth a few readings."
        ),
        mistakes=(
            UsualMistake(0.006, "You divided sigma by the number. The variance goes with one over the number, sigma with its root."),
            UsualMistake(0.0036, "That is the variance, in square metres. Take the root."),
            UsualMistake(0.36, "That is the variance of one reading, in square metres."),
            UsualMistake(0.6, "That is one reading. The mean is better."),
            UsualMistake(6.0, r"You multiplied by $\sqrt{100}$: that is the sigma of the sum. Of the mean you divide."),
        ),
    ),
    Question(
        name="run-away-of-the-printed-equation",
        text=(
            "A receiver's clock gains 40 nanoseconds a second: 12 m of light. By how much has the right side of equation (1) as printed "
            "run away from the carrier after 600 s? Leave out the satellite's clock and the troposphere."
        ),
        answer=14.4,
        tolerance=0.1,
        unit="km",
        hints=(
            r"The carrier grows by $c\,dt_r$. What does the printed right side do with the same clock?",
            r"The carrier gains 12 m a second, the printed side loses 12 m a second. How far apart are they after 600 s?",
        ),
        solution=(
            r"The carrier has $+c\,dt_r$, the print $-c\,dt_r$. They part by 24 m a second: $24 \cdot 600 = 14\,400$ m $= 14.4$ km." "\n\n"
            "Try the preset *As printed*. Between two receivers and two satellites clocks cancel, whatever their sign: there it did no harm."
        ),
        mistakes=(
            UsualMistake(7.2, "That is the clock alone. The carrier goes up with it and the print goes down: twice as much."),
            UsualMistake(14400.0, "That is in metres. The answer is asked in km."),
            UsualMistake(0.024, "That is after one second."),
            UsualMistake(0.0, "The clock cancels between two receivers. With one receiver it stays."),
        ),
    ),
)  # fmt: skip
