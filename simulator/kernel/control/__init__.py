"""What the leg's and the ground emulator's controllers decide, and when."""
