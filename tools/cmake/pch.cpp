// The translation unit that carries a precompiled header (DoppelTargets.cmake); nothing else.
