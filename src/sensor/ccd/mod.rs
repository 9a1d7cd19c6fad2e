//! Charge-coupled devices (CCD): the charge of every pixel is shifted out, row by row and then pixel by pixel, to one
//! amplifier and one converter. What goes wrong on the way: [`blooming`], [`smear`], [`transfer`].

pub(super) mod blooming;
pub(super) mod smear;
pub(super) mod transfer;
