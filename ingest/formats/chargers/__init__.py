"""Files of chargers: hand-kept sheets and makers' logs."""
