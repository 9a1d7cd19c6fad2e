//! The sensors that ship with the program, by name: the files of `assets/sensors`.
