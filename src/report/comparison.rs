//! What a comparison of two pictures has found, for programs.

use serde::Serialize;

use photosite_core::Remedy;

use crate::validation::{ChannelDifference, Comparison, Limits, Picture, VarianceOf, failures};

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

impl ComparisonReport {
    /// Of two pictures that were compared, judged by noise where variances are known, and by limits. What to do about
    /// variances that are not is in the words of a front end.
    pub fn new(
        comparison: Comparison,
        [a, b]: [&Picture; 2],
        limits: &Limits,
        word: impl Fn(&Remedy) -> String,
    ) -> Self {
        let failures = failures(&comparison, limits);
        let judged = comparison.verdict.is_some() || !limits.is_empty() || !failures.is_empty();
        Self {
            a: ComparedFile::new(a),
            b: ComparedFile::new(b),
            untested: untested(&comparison, [a, b], word),
            comparison,
            outcome: if !judged {
                "not judged"
            } else if failures.is_empty() {
                "agree"
            } else {
                "differ"
            },
            failures,
            picture: None,
        }
    }
}

impl ComparedFile {
    fn new(picture: &Picture) -> Self {
        Self {
            file: picture.name.clone(),
            unit: picture.unit.clone(),
            channels: picture.mean.channels().iter().map(|c| c.name.clone()).collect(),
            variances: !picture.variance.channels().is_empty(),
        }
    }
}

/// Which channels noise is not asked about, though the variance of one picture is known or could be, and how to give
/// it.
fn untested(comparison: &Comparison, [a, b]: [&Picture; 2], word: impl Fn(&Remedy) -> String) -> Vec<UntestedChannels> {
    let of = |(letter, other, picture): (&'static str, VarianceOf, &Picture)| {
        let has_moment = |name: &str| picture.has_second_moment(name);
        let is_missing = |c: &&ChannelDifference| {
            c.variance_of == other || c.variance_of == VarianceOf::None && has_moment(&c.channel)
        };
        let channels: Vec<String> = comparison.channels.iter().filter(is_missing).map(|c| c.channel.clone()).collect();
        let has_moments = channels.iter().any(|name| has_moment(name));
        let help = word(&if has_moments { Remedy::Moments(letter) } else { Remedy::Variance(letter) });
        let missing = format!("the variance of {letter} is unknown");
        (!channels.is_empty()).then_some(UntestedChannels { channels, missing, help })
    };
    [("A", VarianceOf::B, a), ("B", VarianceOf::A, b)].into_iter().filter_map(of).collect()
}
