"""Files of robots and data loggers."""
