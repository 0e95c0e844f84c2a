// Empty: LIGGGHTS' contact_model_constants.h includes this list of models, which Debian's package does not ship.
