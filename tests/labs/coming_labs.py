"""Labs that are ready before the text of their lesson is: tested as all others."""

from gnsslab.teaching.catalogue import Lesson

COMING = Lesson("08", "", "Is the slope moving?", "", 0, "", (), ("gnsslab.labs.denoising:denoising_lab",))
