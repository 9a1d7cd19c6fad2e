//! What a comparison of two pictures has found, for programs.

use serde::Serialize;

use crate::validation::Comparison;

/// The object that `photosite compare --json` prints.
#[derive(Clone, Debug, Serialize)]
pub struct ComparisonReport {
    /// The first file.
    pub a: ComparedFile,
    /// The second file.
    pub b: ComparedFile,
    /// The figures.
    #[serde(flatten)]
    pub comparison: Comparison,
    /// "agree", "differ", or "not judged" without variances and limits.
    pub outcome: &'static str,
    /// Why the pictures differ.
    pub failures: Vec<String>,
    /// What noise cannot be asked about.
    pub untested: Vec<UntestedChannels>,
    /// The picture of the differences, if one was written.
    pub picture: Option<DifferencePicture>,
}

/// A picture that was compared.
#[derive(Clone, Debug, Serialize)]
pub struct ComparedFile {
    /// Its path.
    pub file: String,
    /// `null` where the file does not say.
    pub unit: Option<String>,
    /// Names of its channels.
    pub channels: Vec<String>,
    /// Whether their variances are known.
    pub variances: bool,
}

/// Channels that cannot be tested against noise.
#[derive(Clone, Debug, Serialize)]
pub struct UntestedChannels {
    /// Their names.
    pub channels: Vec<String>,
    /// What is not known of them.
    pub missing: String,
    /// What to do about it.
    pub help: String,
}

/// The picture that was written.
#[derive(Clone, Debug, Serialize)]
pub struct DifferencePicture {
    /// Its path.
    pub file: String,
    /// Differences, relative differences or z-scores.
    pub shows: &'static str,
    /// The ends of its colours lie at ± this.
    pub range: f64,
}
