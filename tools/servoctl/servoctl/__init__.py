"""servoctl: tuning of a trackservo over CANopen, the same on the simulator and on the board."""

__version__ = "0.1.0"
