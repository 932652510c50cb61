"""Who may enter, and who may have the rig do something: tokens, sessions, roles, lease, permits."""
