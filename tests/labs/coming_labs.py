"""Labs that are ready before the text of their lesson is: tested as all others."""

from gnsslab.teaching.catalogue import Lesson

OF_LESSON_08 = ("gnsslab.labs.denoising:denoising_lab", "gnsslab.labs.step_response:step_response_lab", "gnsslab.labs.slope_alarm:slope_alarm_lab")
COMING = Lesson("08", "", "Is the slope moving?", "", 0, "", (), OF_LESSON_08)
