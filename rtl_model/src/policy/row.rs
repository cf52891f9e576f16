//! A knob's row: the place of its value, its legal values, and how messages name them.

use alloc::format;
use alloc::string::String;

use super::{Policy, ROWS};
use crate::config::{Config, ConfigError, Tables};

/// A type whose values are numbers to whoever lists, checks or stores them: a number itself, or a literal by its place.
pub trait Setting: Copy {
    /// The value's number.
    fn number(self) -> u32;
    /// The value of a legal number.
    fn of(number: u32) -> Self;
}

impl Setting for u32 {
    fn number(self) -> u32 {
        self
    }

    fn of(number: u32) -> Self {
        number
    }
}

/// 0 is `None`.
impl Setting for Option<u32> {
    fn number(self) -> u32 {
        self.unwrap_or(0)
    }

    fn of(number: u32) -> Self {
        (number != 0).then_some(number)
    }
}

/// Legal values of a knob.
#[derive(Clone, Copy, Debug)]
pub enum Legal {
    /// The literals of a closed set.
    Names(&'static [&'static str]),
    /// Whole numbers of a range.
    Range(u32, u32),
    /// Whole numbers of a range, and what they count.
    Counted(u32, u32, &'static str),
    /// Even numbers of a range.
    Even(u32, u32),
    /// Powers of two of a range.
    PowerOfTwo(u32, u32),
    /// Whole numbers from 0 on.
    Few(u32),
    /// `off`, which is 0, or whole numbers of a range.
    OrOff(u32, u32),
    /// One number, and why; such a path is understood but never listed.
    Only(u32, &'static str),
    /// Decimals of a range.
    Number(u32, u32),
    /// The nine numbers of a rotation.
    Rotation,
}

impl Legal {
    /// Least and greatest number.
    #[must_use]
    pub fn ends(&self) -> [u32; 2] {
        match *self {
            Self::Names(names) => {
                [0, u32::try_from(names.len()).map_or(0, |n| n.saturating_sub(1))]
            }
            Self::Range(low, high)
            | Self::Counted(low, high, _)
            | Self::Even(low, high)
            | Self::PowerOfTwo(low, high)
            | Self::Number(low, high) => [low, high],
            Self::Few(high) | Self::OrOff(_, high) => [0, high],
            Self::Only(n, _) => [n, n],
            Self::Rotation => [0, 0],
        }
    }

    /// Whether a whole number is legal.
    #[must_use]
    pub fn takes(&self, number: u32) -> bool {
        let [low, high] = self.ends();
        (low..=high).contains(&number)
            && match self {
                Self::Even(..) => number.is_multiple_of(2),
                Self::PowerOfTwo(..) => number.is_power_of_two(),
                Self::OrOff(low, _) => number == 0 || number >= *low,
                Self::Names(_)
                | Self::Range(..)
                | Self::Counted(..)
                | Self::Few(_)
                | Self::Only(..)
                | Self::Number(..) => true,
                Self::Rotation => false,
            }
    }

    /// The next smaller legal number, as hardware gets smaller: a bit or a step less, half of a table.
    #[must_use]
    pub fn below(&self, number: u32) -> Option<u32> {
        let less = match self {
            Self::Even(..) => number.checked_sub(2)?,
            Self::PowerOfTwo(..) => number / 2,
            Self::Names(_) | Self::Number(..) | Self::Rotation => return None,
            Self::Range(..)
            | Self::Counted(..)
            | Self::Few(_)
            | Self::OrOff(..)
            | Self::Only(..) => number.checked_sub(1)?,
        };
        self.takes(less).then_some(less)
    }

    /// What a list of knobs says.
    #[must_use]
    pub fn listed(&self) -> String {
        match *self {
            Self::Names(names) => names.join(" | "),
            Self::Range(1, 2) => "1 | 2".into(),
            Self::Few(1) => "0 | 1".into(),
            Self::Few(_) => "0 | 1 | 2".into(),
            Self::Range(low, high) | Self::Counted(low, high, _) | Self::Number(low, high) => {
                format!("{low}…{high}")
            }
            Self::Even(low, high) => format!("even, {low}…{high}"),
            Self::PowerOfTwo(low, high) => format!("a power of two, {low}…{high}"),
            Self::OrOff(low, high) => format!("off | {low}…{high}"),
            Self::Only(n, _) => format!("{n}"),
            Self::Rotation => "nine numbers, a rotation".into(),
        }
    }

    /// What a refusal asks for.
    #[must_use]
    pub fn expected(&self) -> String {
        match *self {
            Self::Names(names) => names.join(" | "),
            Self::Range(low, high) => format!("a whole number from {low} to {high}"),
            Self::Counted(low, high, what) => format!("{low} to {high} {what}"),
            Self::Even(low, high) => format!("an even number from {low} to {high}"),
            Self::PowerOfTwo(low, high) => format!("a power of two from {low} to {high}"),
            Self::Few(1) => "0 or 1".into(),
            Self::Few(_) => "0, 1 or 2".into(),
            Self::OrOff(low, high) => format!("\"off\" or a whole number from {low} to {high}"),
            Self::Only(n, why) => format!("{n}: {why}"),
            Self::Number(low, high) => format!("a number from {low} to {high}"),
            Self::Rotation => "an array of nine numbers, row by row".into(),
        }
    }
}

/// Where a knob's value lies.
#[derive(Clone, Copy, Debug)]
pub enum Place {
    /// In [`Policy`]: how it is read and set.
    Policy(fn(&Policy) -> u32, fn(&mut Policy, u32)),
    /// In a table's knobs.
    Table(fn(&mut Tables) -> &mut u32),
    /// [`Config::roughness_scale`], which float engines have as it was written.
    Scale,
    /// [`Config::rotation`], which float engines have as it was written.
    Rotation,
}

/// A knob.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Path in unit files.
    pub path: &'static str,
    /// Where its value lies.
    pub place: Place,
    /// Legal values.
    pub legal: Legal,
    /// Whether every engine honours it; else the integer model alone does.
    pub all_engines: bool,
    /// The first stage that it reaches; `scene` for what changes what is rendered.
    pub reach: &'static str,
    /// What it does.
    pub meaning: &'static str,
}

/// A row.
pub(super) const fn row(
    path: &'static str,
    place: Place,
    legal: Legal,
    all_engines: bool,
    reach: &'static str,
    meaning: &'static str,
) -> Row {
    Row { path, place, legal, all_engines, reach, meaning }
}

impl Row {
    /// Whether lists and files have it.
    #[must_use]
    pub fn is_listed(&self) -> bool {
        !matches!(self.legal, Legal::Only(..))
    }

    /// Its number; nothing for the two that are no whole numbers.
    #[must_use]
    pub fn get(&self, config: &Config) -> Option<u32> {
        match self.place {
            Place::Policy(get, _) => Some(get(&config.policy)),
            Place::Table(at) => Some(*at(&mut config.tables.clone())),
            Place::Scale | Place::Rotation => None,
        }
    }

    /// Sets its number, which is not checked; the two that are no whole numbers stay.
    pub fn set(&self, config: &mut Config, number: u32) {
        match self.place {
            Place::Policy(_, set) => set(&mut config.policy, number),
            Place::Table(at) => *at(&mut config.tables) = number,
            Place::Scale | Place::Rotation => {}
        }
    }
}

impl Config {
    /// Refuses knobs beyond their legal values.
    pub fn check(&self) -> Result<(), ConfigError> {
        for row in ROWS {
            if let Some(number) = row.get(self)
                && !row.legal.takes(number)
            {
                return Err(ConfigError {
                    path: row.path.into(),
                    expected: row.legal.expected(),
                    found: format!("{number}"),
                });
            }
        }
        Ok(())
    }
}

/// Structs, defaults and rows of the knobs.
macro_rules! knobs {
    (
        $($(#[$doc:meta])* $section:ident: $name:ident {
            $(+ $first:expr;)*
            $($field:ident: $ty:ty $(= $default:expr => $legal:expr)?, $who:ident, $reach:ident, $meaning:literal;)+
        })+
        $(+ $middle:expr;)+
        tables { $($table:ident, $stage:ident, $newton:expr;)+ }
        $(+ $last:expr;)+
    ) => {
        $(
            $(#[$doc])*
            #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
            pub struct $name { $(#[doc = concat!("`", stringify!($field), "`: ", $meaning, ".")] pub $field: $ty),+ }

            impl Default for $name {
                fn default() -> Self {
                    Self { $($field: knobs!(@default $($default)?)),+ }
                }
            }
        )+

        /// Every knob that is neither a format's nor a table's, by the sections of its path.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
        pub struct Policy { $($(#[$doc])* pub $section: $name),+ }

        /// Every knob that is no register's, in the order in which unit files list them.
        pub const ROWS: &[Row] = &[
            $(
                $($first,)*
                $(row(
                    concat!(stringify!($section), ".", stringify!($field)),
                    Place::Policy(
                        |policy| Setting::number(policy.$section.$field),
                        |policy, number| policy.$section.$field = Setting::of(number),
                    ),
                    knobs!(@legal $ty $(, $legal)?),
                    knobs!(@$who),
                    stringify!($reach),
                    $meaning,
                ),)+
            )+
            $($middle,)+
            $(
                row(
                    concat!("tables.", stringify!($table), ".entries"),
                    Place::Table(|t| &mut t.$table.entries),
                    PowerOfTwo(2, 4096), false, stringify!($stage), "intervals",
                ),
                row(
                    concat!("tables.", stringify!($table), ".order"),
                    Place::Table(|t| &mut t.$table.order),
                    Few(2), false, stringify!($stage), "interpolation: none, linear, quadratic",
                ),
                row(
                    concat!("tables.", stringify!($table), ".frac"),
                    Place::Table(|t| &mut t.$table.frac),
                    Counted(2, 28, "bits"), false, stringify!($stage), "fraction bits of an entry",
                ),
                row(
                    concat!("tables.", stringify!($table), ".newton"),
                    Place::Table(|t| &mut t.$table.newton),
                    $newton, false, stringify!($stage), "Newton steps after the look-up",
                ),
            )+
            $($last,)+
        ];
    };
    (@default) => { Default::default() };
    (@default $default:expr) => { $default };
    (@legal $ty:ty) => { Legal::Names(<$ty>::NAMES) };
    (@legal $ty:ty, $legal:expr) => { $legal };
    (@All) => { true };
    (@Rtl) => { false };
}

pub(super) use knobs;
