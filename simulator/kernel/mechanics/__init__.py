"""Forces, motion and energy of body, foot, leg and platform."""
