//! How surfaces scatter light.
