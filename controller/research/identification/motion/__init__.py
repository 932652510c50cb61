"""What decays say: damping, modes and their shapes."""
