"""What is said once: actuator, parameters, messages, modes, states, and how a record of them lies in memory."""
