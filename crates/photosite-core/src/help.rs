//! What to do about an error, in parts that each front end puts into its own words: a command speaks of its options, a
//! library of its arguments.

use std::fmt;

/// What to do: one thing or another.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Help(Vec<Remedy>);

/// One thing to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Remedy {
    /// In words that hold for every caller.
    Say(String),
    /// Allow that earlier results are overwritten.
    Overwrite,
    /// Allow that an earlier beginning is thrown away.
    StartAnew,
    /// Let the results go to `another folder`, `a new folder`, `another file`.
    Elsewhere(String),
    /// Override a key: `render.samples_per_pixel=64`.
    Override(String),
    /// What an override looks like: `noise.read_noise_e=2`.
    Example(String),
    /// Allow so many GiB for the film.
    FilmMemory(String),
    /// Allow so many GiB for the program.
    Memory(String),
    /// Render these samples of each pixel: from the first up to, but without, the second.
    Samples([u32; 2]),
    /// Name these channels.
    Channels(Vec<String>),
    /// Look at the masked pixels of this raw image, too, of which the active area is looked at.
    Masked {
        /// Its name.
        name: String,
        /// Where the active area lies.
        area: String,
    },
    /// Give the variance of the picture that is called so, or say that it is exact.
    Variance(&'static str),
    /// Say of how many samples the second moments of that picture are.
    Moments(&'static str),
    /// Let something stand in for textures that cannot be had.
    Lenient,
    /// Take the nearest that a file format has.
    Nearest,
    /// Say that the numbers of a picture are in proportion to light.
    Linear,
    /// Say what the numbers of a picture are on the sensor.
    LightUnit,
}

impl Help {
    /// One thing or another.
    pub fn any(remedies: impl IntoIterator<Item = Remedy>) -> Self {
        Self(remedies.into_iter().collect())
    }

    /// This, or another thing.
    #[must_use]
    pub fn or(mut self, remedy: Remedy) -> Self {
        self.0.push(remedy);
        self
    }

    /// In the words of a front end: "a", "a, or b", "a, b, or c".
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
            Self::Variance(picture) => write!(f, "give the variance of {picture}; 0 if it is exact"),
            Self::Moments(picture) => {
                write!(f, "state how many samples per pixel the second moments of {picture} come from")
            }
            Self::Lenient => f.write_str("override scene.lenient=true, and grey is used instead"),
            Self::Nearest => f.write_str("ask for the closest equivalent"),
            Self::Linear => f.write_str("state that its codes are proportional to light"),
            Self::LightUnit => f.write_str("say what the numbers of the picture are on the sensor"),
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
