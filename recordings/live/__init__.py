"""The recorder as a process of its own on the rig's link: who runs it, and the socket on which it is asked."""
