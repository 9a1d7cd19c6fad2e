//! Pairs: the channels of two images that face each other.

use photosite_core::{Help, Remedy};
use serde::Serialize;

use photosite_core::Invalid;
use photosite_raw::Cfa;

use super::compared_image::{ComparedImage, MOSAIC};
use super::z_scores::z_score;

/// Images of a pair whose variance is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum VarianceOf {
    /// Variance of neither image.
    None,
    /// Variance of a alone.
    A,
    /// Variance of b alone.
    B,
    /// Variances of both images: their difference has one.
    Both,
}

/// Pair of the same channel on both sides.
pub(super) struct Pair<'a> {
    pub(super) name: &'a str,
    pub(super) a: &'a [f32],
    pub(super) b: &'a [f32],
    variance_a: Option<&'a [f32]>,
    variance_b: Option<&'a [f32]>,
    /// The channel of a mosaic whose pixels alone count; `None`: all pixels do.
    sites: Option<Sites<'a>>,
}

struct Sites<'a> {
    cfa: &'a Cfa,
    channel: usize,
    width: usize,
}

impl Pair<'_> {
    /// Indices of the pixels that the channel has, row by row.
    pub(super) fn pixels(&self) -> impl Iterator<Item = usize> + Clone {
        let has =
            |i: &usize| self.sites.as_ref().is_none_or(|s| s.cfa.channel_at(i % s.width, i / s.width) == s.channel);
        (0..self.a.len()).filter(has)
    }

    /// Indices of the pixels whose values can be compared.
    pub(super) fn finite_pixels(&self) -> impl Iterator<Item = usize> + Clone {
        self.pixels().filter(|&i| self.is_finite(i))
    }

    /// Whether both values of a pixel are finite, and its variance possible.
    pub(super) fn is_finite(&self, i: usize) -> bool {
        let variances = [self.variance_a, self.variance_b].into_iter().flatten().map(|v| v[i]);
        self.a[i].is_finite() && self.b[i].is_finite() && variances.into_iter().all(|v| v.is_finite() && v >= 0.0)
    }

    pub(super) fn a(&self, i: usize) -> f64 {
        f64::from(self.a[i])
    }

    pub(super) fn b(&self, i: usize) -> f64 {
        f64::from(self.b[i])
    }

    pub(super) fn difference(&self, i: usize) -> f64 {
        self.a(i) - self.b(i)
    }

    /// Images whose variance is known.
    pub(super) fn variance_of(&self) -> VarianceOf {
        match (self.variance_a, self.variance_b) {
            (None, None) => VarianceOf::None,
            (Some(_), None) => VarianceOf::A,
            (None, Some(_)) => VarianceOf::B,
            (Some(_), Some(_)) => VarianceOf::Both,
        }
    }

    /// Whether the difference has a variance: it takes those of both sides.
    pub(super) fn has_variance(&self) -> bool {
        self.variance_of() == VarianceOf::Both
    }

    /// var a + var b, where both are known.
    pub(super) fn variance(&self, i: usize) -> f64 {
        [self.variance_a, self.variance_b].into_iter().flatten().map(|v| f64::from(v[i])).sum()
    }

    /// The z-score of a finite pixel; `None` where it has none, or no variances are known.
    pub(super) fn z(&self, i: usize) -> Option<f64> {
        z_score(self.difference(i), self.variance(i)).filter(|_| self.has_variance())
    }
}

/// The channels that both images have, or those of them that are wanted. A mosaic gives one pair for all its pixels,
/// followed by one for each of its channels.
pub(super) fn pairs<'a>(
    a: &'a ComparedImage,
    b: &'a ComparedImage,
    wanted: Option<&[String]>,
) -> Result<Vec<Pair<'a>>, Invalid> {
    refuse_strangers(a, b)?;
    let mosaic = match (&a.mosaic, &b.mosaic) {
        (Some(of_a), Some(of_b)) if of_a != of_b && wanted.is_none_or(|names| names != [MOSAIC]) => {
            let message = format!("the colour filters of {} and {} lie differently over the pixels", a.name, b.name);
            return Err(Invalid::new("", message)
                .help(Help::any(["compare the mosaics as such".into(), Remedy::Channels(vec![MOSAIC.to_owned()])])));
        }
        (Some(cfa), _) | (None, Some(cfa)) => Some(cfa),
        (None, None) => None,
    };
    if wanted.is_none() {
        refuse_one_sided(a, b)?;
    }
    let mut pairs = Vec::new();
    for channel in a.mean.channels() {
        let Some(plane_b) = b.mean.plane(&channel.name) else { continue };
        let pair = |name: &'a str, sites| Pair {
            name,
            a: &channel.data,
            b: plane_b,
            variance_a: a.variance.plane(&channel.name),
            variance_b: b.variance.plane(&channel.name),
            sites,
        };
        pairs.push(pair(&channel.name, None));
        if let Some(cfa) = mosaic.filter(|_| channel.name == MOSAIC) {
            let width = a.mean.width();
            let of = |(channel, name): (usize, &'a String)| pair(name, Some(Sites { cfa, channel, width }));
            pairs.extend(cfa.channels().iter().enumerate().map(of));
        }
    }
    let Some(wanted) = wanted else { return Ok(pairs) };
    for name in wanted {
        if !pairs.iter().any(|pair| pair.name == name) {
            return Err(unknown(name, a, b, &pairs));
        }
    }
    pairs.retain(|pair| wanted.iter().any(|name| name == pair.name));
    if pairs.is_empty() { Err(Invalid::new("", "no channel is chosen")) } else { Ok(pairs) }
}

/// The pairs that have every pixel once: without the channels of a mosaic that is there as a whole.
pub(super) fn once<'p, 'a>(pairs: &'p [Pair<'a>]) -> impl Iterator<Item = &'p Pair<'a>> + Clone {
    let whole = pairs.iter().any(|pair| pair.sites.is_none());
    pairs.iter().filter(move |pair| !whole || pair.sites.is_none())
}

fn refuse_strangers(a: &ComparedImage, b: &ComparedImage) -> Result<(), Invalid> {
    let size = |p: &ComparedImage| [p.mean.width(), p.mean.height()];
    if size(a) != size(b) {
        let [[wa, ha], [wb, hb]] = [size(a), size(b)];
        let message = format!("{} has {wa} × {ha} pixels, {} has {wb} × {hb}", a.name, b.name);
        let help = match [a, b].into_iter().find_map(|image| Some((&image.name, image.active_area?))) {
            Some((name, area)) => Remedy::Masked { name: name.clone(), area: area.to_string() }.into(),
            None => Help::from("only images of the same size can be compared"),
        };
        return Err(Invalid::new("", message).help(help));
    }
    if let (Some(unit_a), Some(unit_b)) = (&a.unit, &b.unit)
        && unit_a != unit_b
    {
        let message = format!("{} holds {unit_a}, {} holds {unit_b}", a.name, b.name);
        return Err(Invalid::new("", message).help("only numbers of the same unit can be compared"));
    }
    Ok(())
}

/// Channels that only one image has must not go unnoticed.
fn refuse_one_sided(a: &ComparedImage, b: &ComparedImage) -> Result<(), Invalid> {
    let (common, only_a): (Vec<_>, Vec<_>) = names(a).partition(|name| b.mean.plane(name).is_some());
    let only_b: Vec<_> = names(b).filter(|name| a.mean.plane(name).is_none()).collect();
    let lacks = |p: &ComparedImage, names: &[&str]| {
        (!names.is_empty()).then(|| format!("{} lacks {}, which the other has", p.name, names.join(", ")))
    };
    if common.is_empty() {
        let list = |p| names(p).collect::<Vec<_>>().join(", ");
        let message = format!("{} and {} have no channel in common", a.name, b.name);
        let help = format!("the first has {}, the second {}", list(a), list(b));
        return Err(Invalid::new("", message).help(help));
    }
    let lacking: Vec<String> = [lacks(b, &only_a), lacks(a, &only_b)].into_iter().flatten().collect();
    if lacking.is_empty() {
        return Ok(());
    }
    let help = Remedy::Channels(common.iter().map(|&name| name.to_owned()).collect());
    Err(Invalid::new("", lacking.join("; ")).help(help))
}

fn unknown(name: &str, a: &ComparedImage, b: &ComparedImage, pairs: &[Pair<'_>]) -> Invalid {
    let message = match (a.mean.plane(name), b.mean.plane(name)) {
        (None, Some(_)) => format!("{} has no channel {name:?}", a.name),
        (Some(_), None) => format!("{} has no channel {name:?}", b.name),
        (None, None) | (Some(_), Some(_)) => format!("there is no channel {name:?}"),
    };
    let common: Vec<_> = pairs.iter().map(|pair| pair.name).collect();
    let help = if common.is_empty() { "nothing".to_owned() } else { common.join(", ") };
    Invalid::new("", message).help(format!("both have {help}"))
}

fn names(image: &ComparedImage) -> impl Iterator<Item = &str> {
    image.mean.channels().iter().map(|c| &c.name[..])
}

#[cfg(test)]
mod tests {
    use rstest::rstest;

    use super::*;
    use crate::validation::compared_image::tests::image;
    use photosite_raw::{Pixels, RawImage};

    fn names(pairs: &[Pair<'_>]) -> Vec<String> {
        pairs.iter().map(|pair| pair.name.to_owned()).collect()
    }

    fn wanted(names: &[&str]) -> Vec<String> {
        names.iter().map(|&name| name.to_owned()).collect()
    }

    fn mosaic(cfa: &str) -> ComparedImage {
        let raw = RawImage {
            width: 3,
            height: 2,
            data: (0..6).collect(),
            cfa: Cfa::parse(cfa).expect("known"),
            bits: 12,
            white_level_dn: 4095,
            ..RawImage::default()
        };
        ComparedImage::from_raw(format!("{cfa}.dng"), raw, Pixels::Active)
    }

    #[test]
    fn channels_that_one_side_lacks_are_refused_unless_others_are_chosen() {
        let a = image(1, 1, &[("R", &[1.0]), ("G", &[2.0]), ("X", &[3.0])]);
        let b = image(1, 1, &[("G", &[2.0]), ("R", &[1.0]), ("B", &[4.0])]);
        let error = pairs(&a, &b, None).err().expect("refused");
        assert!(error.message.contains("lacks X") && error.message.contains("lacks B"), "{error}");
        assert!(error.help.expect("helpful").to_string().contains("channels R,G"));
        assert_eq!(names(&pairs(&a, &b, Some(&wanted(&["G"]))).expect("common")), ["G"]);
        for (name, complaint) in [("X", "has no channel \"X\""), ("Q", "there is no channel \"Q\"")] {
            let error = pairs(&a, &b, Some(&wanted(&["R", name]))).err().expect("refused");
            assert!(error.message.contains(complaint), "{error}");
            assert_eq!(error.help, Some("both have R, G".into()));
        }
        assert!(pairs(&a, &b, Some(&[])).is_err());
    }

    #[test]
    fn images_that_have_nothing_in_common_are_refused() {
        let a = image(2, 1, &[("R", &[1.0, 2.0])]);
        let other_size = image(1, 2, &[("R", &[1.0, 2.0])]);
        let other_name = image(2, 1, &[("Y", &[1.0, 2.0])]);
        let unit = |unit: &str| ComparedImage { unit: Some(unit.to_owned()), ..a.clone() };
        for (a, b, complaint) in [
            (&a, &other_size, "2 × 1 pixels"),
            (&a, &other_name, "no channel in common"),
            (&unit("e-"), &unit("DN"), "holds DN"),
        ] {
            let error = pairs(a, b, None).err().expect("refused");
            assert!(error.message.contains(complaint), "{error}");
        }
        assert!(pairs(&a, &unit("DN"), None).is_ok(), "a unit that is not known is no other one");
    }

    #[rstest]
    #[case::both("RGGB", "RGGB")]
    #[case::the_first("RGGB", "mono")]
    #[case::the_second("mono", "RGGB")]
    fn mosaics_are_compared_as_a_whole_and_by_channel(#[case] a: &str, #[case] b: &str) {
        let (a, b) = (mosaic(a), mosaic(b));
        let found = pairs(&a, &b, None).expect("comparable");
        let pixels: Vec<(&str, Vec<usize>)> = found.iter().map(|pair| (pair.name, pair.pixels().collect())).collect();
        let of = |name, pixels: &[usize]| (name, pixels.to_vec());
        assert_eq!(pixels, [of("raw", &[0, 1, 2, 3, 4, 5]), of("R", &[0, 2]), of("G", &[1, 3, 5]), of("B", &[4])]);
        let whole: Vec<_> = once(&found).map(|pair| pair.name).collect();
        assert_eq!(whole, ["raw"]);
        let chosen = pairs(&a, &b, Some(&wanted(&["R", "B"]))).expect("comparable");
        let each: Vec<_> = once(&chosen).map(|pair| pair.name).collect();
        assert_eq!(each, ["R", "B"]);
    }

    #[test]
    fn mosaics_of_different_filters_are_compared_as_such_only() {
        let (a, b) = (mosaic("RGGB"), mosaic("BGGR"));
        assert!(pairs(&a, &b, None).is_err());
        let raw = wanted(&["raw"]);
        assert_eq!(names(&pairs(&a, &b, Some(&raw)).expect("comparable")), ["raw"]);
    }
}
