//! Spectral sensitivities of a camera from images of a chart whose reflectances are known, in light that is known.
//!
//! | file | holds |
//! |---|---|
//! | `chart.rs` | places of the patches in an image, and their means |
//! | `log_process.rs` | a curve by its positive prior and a few linear measurements |
//! | `estimate.rs` | the curves of all channels, with their errors |

mod chart;
mod estimate;
mod log_process;

pub use chart::{ChartGrid, PatchMean, patch_means};
pub use estimate::{LitChart, Sensitivities, Sensitivity, sensitivities};
