//! OptiX Toolkit's constant gradient of a cone on a cube map against the Jacobian of the face coordinates.

use crate::distance::Distance;
use crate::engine::hit::HitF64;
use crate::fragment::HitFragment;
use crate::policy::ConeEnv;
use crate::reference::NoTap;
use crate::settings::Settings;

/// Footprint of a cone of 0.01 rad at a place of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// (u, v) on the face.
    pub place: [f64; 2],
    /// λ1/α and λ2/α by the Jacobian.
    pub exact: [f64; 2],
    /// λ/α by the constant.
    pub constant: f64,
}

impl Row {
    /// The constant over λ1, over λ2 and over their geometric mean, less 1.
    #[must_use]
    pub fn errors(&self) -> [f64; 3] {
        let [a, b] = self.exact;
        [a, b, (a * b).sqrt()].map(|x| self.constant / x - 1.0)
    }
}

/// Places along a face's axis and along its diagonal, from the middle to the edge and to the corner.
#[must_use]
pub fn rows(steps: u32) -> Vec<Row> {
    const ANGLE: f64 = 0.01;
    let nothing = Distance::nothing();
    let engine = |env: ConeEnv| {
        let mut settings = Settings::default();
        settings.policy.cone.env = env;
        HitF64::new(&settings, &nothing, None, 256)
    };
    let [exact, constant] = [ConeEnv::Exact, ConeEnv::Otk].map(engine);
    let lambda = |engine: &HitF64<'_>, [u, v]: [f64; 2]| {
        let ray = HitFragment {
            x: [0.0; 3],
            // Face +z: sc = x, tc = −y.
            r: [u, -v, 1.0],
            cone: Some([ANGLE, 0.0]),
        };
        let env = engine.trace(&ray, &mut NoTap).env;
        env.map_or([0.0; 2], |env| env.lambda.map(|l| l / ANGLE))
    };
    let row = |place: [f64; 2]| Row {
        place,
        exact: lambda(&exact, place),
        constant: lambda(&constant, place)[0],
    };
    let along = (0..=steps).map(|i| f64::from(i) / f64::from(steps.max(1)));
    let axis = along.clone().map(|u| row([u, 0.0]));
    axis.chain(along.skip(1).map(|u| row([u, u]))).collect()
}
