//! The request of a trace line: reading and writing it.

use serde_json::value::RawValue;
use serde_json::{Map, Value, json};

use super::line::{Line, entries, number, short};
use crate::error::InputError;
use crate::fragment::{Fragment, HitFragment, Tangents, TexFragment};
use crate::reference::ray_cone::Step;

/// The request of a line.
#[derive(Clone, Debug)]
pub(super) enum Request {
    /// Filter the environment for a fragment.
    Env(Fragment),
    /// Find where a ray meets a distance map.
    Hit(HitFragment),
    /// A cone's footprint on a textured surface.
    Tex(TexFragment, [f64; 2]),
    /// A cone through a list of steps.
    Cone([f64; 2], Vec<Step>),
}

/// Most steps of a line.
const MAX_STEPS: usize = 65_536;

impl Request {
    /// The request of a line.
    pub(super) fn read(line: &Line<'_>) -> Result<Self, InputError> {
        let expected = "\"env\", \"hit\", \"cone\" or \"tex\"";
        let value = line.need("op", expected)?.get();
        match serde_json::from_str::<String>(value).as_deref() {
            Ok("env") => env(line).map(Self::Env),
            Ok("hit") => {
                line.only(&["op", "x", "r", "cone"])?;
                Ok(Self::Hit(HitFragment {
                    x: line.array("x", "")?,
                    r: line.array("r", "")?,
                    cone: line.optional("cone")?,
                }))
            }
            Ok("tex") => {
                line.only(&["op", "cone", "d", "n", "dp_ds", "dp_dt"])?;
                let cone = line.array("cone", "")?;
                let fragment = TexFragment {
                    d: line.array("d", "")?,
                    n: line.array("n", "")?,
                    tangents: Tangents::Surface {
                        dp_ds: line.array("dp_ds", "")?,
                        dp_dt: line.array("dp_dt", "")?,
                    },
                    st: [0.5; 2],
                };
                Ok(Self::Tex(fragment, cone))
            }
            Ok("cone") => {
                line.only(&["op", "cone", "steps"])?;
                Ok(Self::Cone(line.array("cone", ", angle and width")?, steps(line)?))
            }
            Ok(op) => Err(line.error("op", expected, format!("\"{}\"", short(op)))),
            Err(_) => Err(line.error("op", expected, short(value))),
        }
    }

    /// The keys of a line that asks for it; steps of a cone are never written.
    pub(super) fn entries(&self) -> Map<String, Value> {
        let mut map = Map::new();
        let mut put = |key: &str, value: Value| map.insert(key.into(), value);
        match self {
            Self::Env(f) => {
                put("op", json!("env"));
                put("v", json!(f.v));
                put("n", json!(f.n));
                put("dv_dx", json!(f.dv_dx));
                put("dv_dy", json!(f.dv_dy));
                put("dn_dx", json!(f.dn_dx));
                put("dn_dy", json!(f.dn_dy));
                f.h.map(|h| put("h", json!(h)));
                f.bump.map(|b| put("bump", json!(b)));
                f.rough.map(|d| put("rough", json!(d)));
            }
            Self::Hit(ray) => {
                put("op", json!("hit"));
                put("x", json!(ray.x));
                put("r", json!(ray.r));
                ray.cone.map(|cone| put("cone", json!(cone)));
            }
            Self::Tex(fragment, cone) => {
                let (dp_ds, dp_dt) = fragment.tangents.derivatives();
                put("op", json!("tex"));
                put("cone", json!(cone));
                put("d", json!(fragment.d));
                put("n", json!(fragment.n));
                put("dp_ds", json!(dp_ds));
                put("dp_dt", json!(dp_dt));
            }
            Self::Cone(cone, _) => {
                put("op", json!("cone"));
                put("cone", json!(cone));
            }
        }
        map
    }
}

fn env(line: &Line<'_>) -> Result<Fragment, InputError> {
    line.only(&["op", "v", "n", "dv_dx", "dv_dy", "dn_dx", "dn_dy", "h", "bump", "rough"])?;
    let fragment = Fragment {
        v: line.array("v", "")?,
        n: line.array("n", "")?,
        dv_dx: line.array("dv_dx", "")?,
        dv_dy: line.array("dv_dy", "")?,
        dn_dx: line.array("dn_dx", "")?,
        dn_dy: line.array("dn_dy", "")?,
        h: line.optional("h")?,
        bump: line.optional("bump")?,
        rough: line.optional("rough")?,
    };
    for (key, there) in [("bump", fragment.bump.is_some()), ("rough", fragment.rough.is_some())] {
        if there && fragment.h.is_none() {
            return Err(line.error(key, "the main direction `h` beside it", "no `h`".into()));
        }
    }
    Ok(fragment)
}

/// The steps, each an object with one key.
fn steps(line: &Line<'_>) -> Result<Vec<Step>, InputError> {
    let list = "an array of steps";
    let raw = line.need("steps", list)?.get();
    let items: Vec<&RawValue> =
        serde_json::from_str(raw).map_err(|_| line.error("steps", list, short(raw)))?;
    if items.len() > MAX_STEPS {
        let most = format!("at most {MAX_STEPS} steps");
        return Err(line.error("steps", &most, items.len().to_string()));
    }
    items.iter().enumerate().map(|(i, item)| step(line, item, i)).collect()
}

fn step(line: &Line<'_>, item: &RawValue, index: usize) -> Result<Step, InputError> {
    let place = format!("steps[{index}]");
    let expected = "one of {\"propagate\":d}, {\"reflect\":{\"k\":_}}, {\"refract\":{\"k\":_,\"no\":_,\"ni\":_}}, {\"scatter\":{\"f\":_}}";
    let wrong = || line.error(&place, expected, short(item.get()));
    let steps = entries(item.get()).map_err(|_| wrong())?;
    let [(name, value)] = steps.as_slice() else {
        return Err(wrong());
    };
    let fields = |names: &[&str]| -> Result<Vec<f64>, InputError> {
        let inner = entries(value.get()).map_err(|_| wrong())?;
        if inner.len() != names.len() {
            return Err(wrong());
        }
        names
            .iter()
            .map(|name| {
                let (_, raw) = inner.iter().find(|(k, _)| k == name).ok_or_else(wrong)?;
                number(raw.get()).map_err(|_| wrong())
            })
            .collect()
    };
    Ok(match name.as_str() {
        "propagate" => Step::Propagate(number(value.get()).map_err(|_| wrong())?),
        "reflect" => Step::Reflect(fields(&["k"])?[0]),
        "refract" => {
            let f = fields(&["k", "no", "ni"])?;
            let positive = |x: f64| x > 0.0;
            if !(positive(f[1]) && positive(f[2])) {
                return Err(line.error(&place, "refractive indices above 0", short(item.get())));
            }
            Step::Refract { curvature: f[0], outside: f[1], inside: f[2] }
        }
        "scatter" => {
            let f = fields(&["f"])?[0];
            if f < 0.0 {
                return Err(line.error(&place, "a BSDF value of at least 0", short(item.get())));
            }
            Step::Scatter(f)
        }
        _ => return Err(wrong()),
    })
}
