"""The lessons of the course: title, order, time, what they need and what they give; defined here and nowhere else."""

from dataclasses import dataclass
from importlib import import_module

from gnsslab.data.locations import project_folder


@dataclass(frozen=True)
class Lesson:
    """One lesson of the course."""

    number: str  # "00"
    file: str  # name in the folder of lessons
    title: str
    teaser: str  # one sentence
    minutes: int
    needs: str  # what to know before
    gives: tuple[str, ...]  # what you will be able to do
    labs: tuple[str, ...]  # "module:function", each returns a fresh Lab

    @property
    def address(self):
        """Path of the lesson on the course's server: "/lesson/00/"."""
        return f"/lesson/{self.number}/"

    @property
    def path(self):
        """The lesson's notebook on this machine."""
        return project_folder("lessons") / self.file

    def open_labs(self):
        """Return fresh labs by name: a dictionary in the order of the lesson."""
        labs = [getattr(import_module(module), function)() for module, function in (place.split(":") for place in self.labs)]
        return {lab.name: lab for lab in labs}

    @property
    def exercises(self):
        """The lesson's module of exercises: PREDICTION and QUESTIONS."""
        return import_module(f"gnsslab.teaching.exercises.lesson_{self.number}")


LESSONS = (
    Lesson(
        "00",
        "00_which_way_is_north.py",
        "Which way is north?",
        "Two cheap receivers on a roof find north better than a compass. The whole chain in one picture.",
        25,
        "school trigonometry; no satellite navigation",
        (
            "read heading and pitch off a baseline of two antennas",
            "say what a longer beam buys, and what it does not",
            "tell a fixed answer from a float one, and know which to trust",
            "get heading out of your own two RINEX files with six lines",
        ),
        ("gnsslab.labs.north:north_lab", "gnsslab.labs.printed_angles:printed_angles_lab"),
    ),
    Lesson(
        "01",
        "01_what_a_receiver_measures.py",
        "What a receiver measures",
        "Code, carrier and Doppler: a ruler good to half a metre, one good to two millimetres that hides a whole number, and how fast both run.",
        40,
        "what a wave is; no satellite navigation",
        (
            "say what is in a code and in a carrier, term by term, with signs",
            "see a cycle slip, and say how large it is in metres",
            "tell noise, multipath, ionosphere and clock apart by looking at code minus carrier",
            "choose an elevation mask, and say what HDOP and VDOP promise",
        ),
        ("gnsslab.labs.signal:signal_lab", "gnsslab.labs.sky:sky_lab"),
    ),
    Lesson(
        "02",
        "02_differences.py",
        "Differences",
        "Clocks are wrong by a hundred kilometres. Two subtractions leave millimetres, and a price: whatever is left goes up and down together.",
        45,
        "lesson 01; what a variance and a matrix are",
        (
            "say what cancels in a single and in a double difference, and what is left after ten kilometres",
            "say what a clock that is a millisecond off does, and how to make it do nothing",
            "write down the covariance of double differences, and show where it comes from",
            "see what a solver loses that ignores the correlation, or forgets to square its sigmas",
        ),
        ("gnsslab.labs.cancelling:cancelling_lab", "gnsslab.labs.correlation:correlation_lab"),
    ),
    Lesson(
        "03",
        "03_why_integers_make_centimetres.py",
        "Why integers make centimetres",
        "Ten whole numbers lie between half a metre and a centimetre. How they are found, and why rounding does not do.",
        60,
        "lesson 02; what an ellipse and a determinant are",
        (
            "get float and fixed positions out of the same measurements, and say what lies between them",
            "tell rounding, bootstrapping and least squares apart, and say how often each is right",
            "decorrelate two ambiguities by hand, and say what stays and what changes",
            "read success rate and ADOP before you have measured anything",
        ),
        ("gnsslab.labs.centimetres:centimetres_lab", "gnsslab.labs.cells:cells_lab", "gnsslab.labs.spectrum:spectrum_lab"),
    ),
    Lesson(
        "04",
        "04_can_you_trust_the_fix.py",
        "Can you trust the fix?",
        "A fix passes the test with a ratio of ten, and is a third of a metre off. How often is that so, and what is better than yes or no?",
        90,
        "lesson 03",
        (
            "say how often a fix will be right before you measure, and count whether it was",
            "choose how many wrong fixes you can bear, and get the threshold from that",
            "fix what is certain and leave the rest, or take the mean of all integers",
            "put a known length where it helps, and only once",
        ),
        (
            "gnsslab.labs.trust:trust_lab",
            "gnsslab.labs.soft_fixing:soft_fixing_lab",
            "gnsslab.labs.known_length:known_length_lab",
            "gnsslab.labs.fewer_satellites:fewer_satellites_lab",
        ),
    ),
    Lesson(
        "05",
        "05_the_known_length.py",
        "The known length",
        "Two cheap receivers on a car's roof, and a tape measure. The length makes neither angle sharper, "
        "yet it finds the whole numbers at once: if it is put in the right place.",
        90,
        "lesson 04; what a Kalman filter is for",
        (
            "build the filter of a published dual-antenna system, and say what each part of it does",
            "say along which direction a known length helps, and where it must go to do no harm",
            "judge a filter by its innovations, and say what they cannot tell",
            "say what two clocks apart do to the heading of a moving car, and put it right",
        ),
        (
            "gnsslab.labs.three_filters:three_filters_lab",
            "gnsslab.labs.filter_health:filter_health_lab",
            "gnsslab.labs.length_forms:length_forms_lab",
            "gnsslab.labs.platforms:platforms_lab",
        ),
    ),
)


def find_lesson(number):
    """Return the lesson of that number: "00", "0" or 0.

    >>> find_lesson(0).title
    'Which way is north?'
    """
    wanted = f"{int(number):02d}" if str(number).isdecimal() else number
    for lesson in LESSONS:
        if lesson.number == wanted:
            return lesson
    raise ValueError(f"there is no lesson {number}: the course has {', '.join(lesson.number for lesson in LESSONS)}")
