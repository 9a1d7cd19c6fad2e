//! Report of a comparison of two images, for programs.

use serde::Serialize;

use photosite_core::Remedy;

use photosite_measure::validation::{ChannelDifference, ComparedImage, Comparison, Limits, VarianceOf, failures};

/// Object that `photosite compare --json` prints.
#[derive(Clone, Debug, Serialize)]
pub struct ComparisonReport {
    /// The first file.
    pub a: ComparedFile,
    /// The second file.
    pub b: ComparedFile,
    /// Figures of the comparison.
    #[serde(flatten)]
    pub comparison: Comparison,
    /// "agree", "differ", or "not judged" without variances and limits.
    pub outcome: &'static str,
    /// Reasons why the images differ.
    pub failures: Vec<String>,
    /// Channels that cannot be tested against noise.
    pub untested: Vec<UntestedChannels>,
    /// Image of the differences, if one was written.
    pub picture: Option<DifferenceImage>,
}

/// Compared image.
#[derive(Clone, Debug, Serialize)]
pub struct ComparedFile {
    /// Path of the file.
    pub file: String,
    /// Unit of the values; `null` where the file does not state it.
    pub unit: Option<String>,
    /// Names of the file's channels.
    pub channels: Vec<String>,
    /// Whether the variances of the file's channels are known.
    pub variances: bool,
}

/// Channels that cannot be tested against noise.
#[derive(Clone, Debug, Serialize)]
pub struct UntestedChannels {
    /// Names of the channels.
    pub channels: Vec<String>,
    /// Missing knowledge about the channels.
    pub missing: String,
    /// Advice on supplying it.
    pub help: String,
}

/// Image of the differences.
#[derive(Clone, Debug, Serialize)]
pub struct DifferenceImage {
    /// Path of the file.
    pub file: String,
    /// Differences, relative differences or z-scores.
    pub shows: &'static str,
    /// Value at the ends of the colour scale, ±.
    pub range: f64,
}

impl ComparisonReport {
    /// Report of two compared images, judged by noise where variances are known, and by limits. `word` puts advice on
    /// missing variances into the words of a front end.
    pub fn new(
        comparison: Comparison,
        [a, b]: [&ComparedImage; 2],
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
    fn new(image: &ComparedImage) -> Self {
        Self {
            file: image.name.clone(),
            unit: image.unit.clone(),
            channels: image.mean.channels().iter().map(|c| c.name.clone()).collect(),
            variances: !image.variance.channels().is_empty(),
        }
    }
}

/// Channels that are not tested against noise, though the variance of one image is known or could be, and how to give
/// it.
fn untested(
    comparison: &Comparison,
    [a, b]: [&ComparedImage; 2],
    word: impl Fn(&Remedy) -> String,
) -> Vec<UntestedChannels> {
    let of = |(letter, other, image): (&'static str, VarianceOf, &ComparedImage)| {
        let has_moment = |name: &str| image.has_second_moment(name);
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
