//! `--min-psnr a:b=DB` and `--max-lsb8 a:b=N`.

use crate::engine::EngineKind;
use crate::error::InputError;

/// A bound on a pair of engines.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Bound {
    pub(super) a: EngineKind,
    pub(super) b: EngineKind,
    pub(super) limit: f64,
}

/// Parses `a:b=number` for the flag `name`.
pub(super) fn parse(name: &str, text: &str) -> Result<Bound, InputError> {
    let kind = |t: &str| EngineKind::ALL.into_iter().find(|r| r.name() == t);
    text.split_once('=')
        .and_then(|(pair, limit)| {
            let (a, b) = pair.split_once(':')?;
            let limit = limit.parse::<f64>().ok().filter(|x| x.is_finite())?;
            Some(Bound { a: kind(a)?, b: kind(b)?, limit })
        })
        .ok_or_else(|| {
            InputError::new(
                name,
                "two engines and a number, such as rtl:f64=50",
                format!("`{text}`"),
                "engines are rtl, gpu, f64, ewa and truth",
            )
        })
}
