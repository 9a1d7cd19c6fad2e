//! Remedies for errors, in parts that each front end puts into its own words: a command speaks of its options, a
//! library of its arguments.

use std::fmt;

/// Alternatives for curing an error: one remedy or another.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Help(Vec<Remedy>);

/// A single remedy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Remedy {
    /// Advice in words that hold for every front end.
    Say(String),
    /// Allow overwriting earlier results.
    Overwrite,
    /// Allow discarding a run begun earlier.
    StartAnew,
    /// Write the results to another place: `another folder`, `a new folder`, `another file`.
    Elsewhere(String),
    /// Override a key: `render.samples_per_pixel=64`.
    Override(String),
    /// Override a key, with an example: `noise.read_noise_e=2`.
    Example(String),
    /// Allow this number of GiB for the film.
    FilmMemory(String),
    /// Allow this number of GiB for the program.
    Memory(String),
    /// Render these samples of each pixel: from the first up to, but not including, the second.
    Samples([u32; 2]),
    /// Name these channels.
    Channels(Vec<String>),
    /// Include the masked pixels of a raw image, of which only the active area was asked for.
    Masked {
        /// Name of the image.
        name: String,
        /// Rectangle of the active area.
        area: String,
    },
    /// Give the variance of the image of this name, or state that the image is exact.
    Variance(&'static str),
    /// State the number of samples per pixel behind the second moments of the image of this name.
    Moments(&'static str),
    /// Let grey stand in for textures that are missing.
    Lenient,
    /// Take the closest equivalent that a file format has.
    Nearest,
    /// State that pixel values are proportional to light.
    Linear,
    /// State the quantity on the sensor that pixel values are.
    LightUnit,
}

impl Help {
    /// Alternatives, of which any one is enough.
    pub fn any(remedies: impl IntoIterator<Item = Remedy>) -> Self {
        Self(remedies.into_iter().collect())
    }

    /// Adds an alternative.
    #[must_use]
    pub fn or(mut self, remedy: Remedy) -> Self {
        self.0.push(remedy);
        self
    }

    /// Text of the alternatives in the words of a front end: "a", "a, or b", "a, b, or c".
    pub fn in_words(&self, word: impl Fn(&Remedy) -> String) -> String {
        let words: Vec<String> = self.0.iter().map(word).collect();
        match &words[..] {
            [] => String::new(),
            [one] => one.clone(),
            [first @ .., last] => format!("{}, or {last}", first.join(", ")),
        }
    }
}

impl fmt::Display for Remedy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Say(words) => f.write_str(words),
            Self::Overwrite => f.write_str("allow overwriting"),
            Self::StartAnew => f.write_str("allow it to start again"),
            Self::Elsewhere(place) => write!(f, "choose {place}"),
            Self::Override(change) => write!(f, "override {change}"),
            Self::Example(change) => write!(f, "for example {change}"),
            Self::FilmMemory(gib) => write!(f, "allow {gib} GiB for the film"),
            Self::Memory(gib) => write!(f, "allow {gib} GiB of memory"),
            Self::Samples([from, to]) => write!(f, "render the samples {from}..{to}"),
            Self::Channels(names) => write!(f, "name the channels {}", names.join(",")),
            Self::Masked { name, area } => {
                write!(f, "of {name} the active area is looked at, {area}; ask for its masked pixels, too")
            }
            Self::Variance(image) => write!(f, "give the variance of {image}; 0 if it is exact"),
            Self::Moments(image) => {
                write!(f, "state how many samples per pixel the second moments of {image} come from")
            }
            Self::Lenient => f.write_str("override scene.lenient=true, and grey is used instead"),
            Self::Nearest => f.write_str("ask for the closest equivalent"),
            Self::Linear => f.write_str("state that its codes are proportional to light"),
            Self::LightUnit => f.write_str("say what the pixel values of the image are on the sensor"),
        }
    }
}

impl fmt::Display for Help {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.in_words(Remedy::to_string))
    }
}

impl From<Remedy> for Help {
    fn from(remedy: Remedy) -> Self {
        Self(vec![remedy])
    }
}

impl From<String> for Help {
    fn from(words: String) -> Self {
        Remedy::Say(words).into()
    }
}

impl From<&str> for Help {
    fn from(words: &str) -> Self {
        words.to_owned().into()
    }
}

impl From<&str> for Remedy {
    fn from(words: &str) -> Self {
        Self::Say(words.to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn remedies_are_joined_as_people_say_them() {
        let elsewhere = || Remedy::Elsewhere("another folder".to_owned());
        assert_eq!(Help::from("wait").to_string(), "wait");
        let two = Help::any([Remedy::Overwrite, elsewhere()]);
        assert_eq!(two.to_string(), "allow overwriting, or choose another folder");
        let three = Help::any(["undo the change".into(), Remedy::StartAnew, elsewhere()]);
        assert_eq!(three.to_string(), "undo the change, allow it to start again, or choose another folder");
        let flags = two.in_words(|remedy| if *remedy == Remedy::Overwrite { "--force".into() } else { "-o".into() });
        assert_eq!(flags, "--force, or -o");
    }
}
