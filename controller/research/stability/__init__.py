"""Is the observer stable, and the loop around it: small motions about every static pose, of the code as it runs."""
