//! Closed sets of named values: an enum, all its values, and the literals that unit files use.

macro_rules! literals {
    ($(#[$doc:meta])* $name:ident { $($(#[$vdoc:meta])* $variant:ident = $text:literal),+ $(,)? } $(default $default:ident)?) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum $name { $($(#[$vdoc])* $variant),+ }

        impl $name {
            /// Every value, in the order in which the documentation lists them.
            pub const ALL: &'static [Self] = &[$(Self::$variant),+];
            /// The literals that unit files use, in the order of the values.
            pub const NAMES: &'static [&'static str] = &[$($text),+];

            /// The literal that unit files use.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => $text),+ }
            }

            /// The value with that literal, if there is one.
            #[must_use]
            pub fn parse(text: &str) -> Option<Self> {
                match text { $($text => Some(Self::$variant),)+ _ => None }
            }
        }

        impl $crate::policy::Setting for $name {
            fn number(self) -> u32 {
                let place = Self::ALL.iter().position(|value| *value == self);
                place.and_then(|place| u32::try_from(place).ok()).unwrap_or(0)
            }

            fn of(number: u32) -> Self {
                let place = usize::try_from(number).ok();
                place.and_then(|place| Self::ALL.get(place)).copied().unwrap_or(Self::ALL[0])
            }
        }

        $(impl Default for $name {
            fn default() -> Self { Self::$default }
        })?
    };
}

pub(crate) use literals;
