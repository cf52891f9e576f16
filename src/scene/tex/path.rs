//! Paths of light through a scene of the TEX operation, in exact geometry: what they ask textures and how their cones
//! change on the way. No engine takes part, so that every engine filters along the same paths.

use glam::{DVec3, dvec3};

use super::TexScene;
use super::shape::Contact;
use crate::base::random::Keyed;
use crate::base::vector::unit;
use crate::fragment::TexFragment;
use crate::optics::{fresnel, refract};
use crate::reference::ray_cone::Step;

/// A surface's effect on a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Finish {
    /// Shows a texture by daylight; the path ends.
    Lit {
        /// Which texture.
        texture: usize,
    },
    /// Reflects everything.
    Mirror,
    /// Reflects by Fresnel's share or refracts, one of them at random.
    Glass {
        /// Index of refraction.
        index: f64,
    },
    /// A texture under a glaze that reflects a part.
    Glazed {
        /// Which texture.
        texture: usize,
        /// The share that the glaze reflects.
        share: f64,
        /// Whether the inner side is matt instead: it scatters what comes.
        lined: bool,
    },
}

/// One request to a texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Which texture.
    pub texture: usize,
    /// The ray at the surface.
    pub fragment: TexFragment,
    /// Linear RGB factor of the texture's colour.
    pub weight: f64,
    /// Bounces before it.
    pub bounce: u32,
}

/// The events on a path, in order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// The cones change.
    Step(Step),
    /// A texture is asked.
    Look(Look),
    /// The path leaves for the environment in a direction.
    Sky {
        /// Unit vector.
        direction: [f64; 3],
        /// Factor of the light seen there.
        weight: f64,
    },
}

/// A path from the eye.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Path {
    /// Unit direction of its first ray.
    pub direction: [f64; 3],
    /// Its events.
    pub events: Vec<Event>,
}

/// Least weight that a path goes on with.
const LEAST: f64 = 1.0 / 256.0;
/// Where the next ray starts to look, so that it does not meet its own surface again.
const BEYOND: f64 = 1e-9;
/// Mean reflectance of matt glaze.
const MATT: f64 = 0.5;

impl TexScene {
    /// The path of a sample, of so many, at an image position (pixels from the top left corner).
    pub fn path(&self, at: [f64; 2], [sample, samples]: [u32; 2], path: &mut Path) {
        let mut random = Keyed::new(u64::from(sample), at, 0);
        let (mut origin, mut direction) = self.camera.ray(at, sample, samples, &mut random);
        path.direction = direction.to_array();
        path.events.clear();
        let mut weight = 1.0;
        for bounce in 0..=self.bounces {
            let shown = self.shows(bounce);
            let Some((contact, finish)) = self.meet(origin, direction) else {
                let sky = Event::Sky { direction: direction.to_array(), weight };
                path.events.extend(shown.then_some(sky));
                return;
            };
            let (n, point) = (contact.normal, origin + contact.t * direction);
            path.events.push(Event::Step(Step::Propagate(contact.t)));
            let look = |share: f64| {
                let (texture, (st, tangents)) = match finish {
                    _ if !shown => return None,
                    Finish::Lit { texture } | Finish::Glazed { texture, .. } => {
                        (texture, contact.texture?)
                    }
                    Finish::Mirror | Finish::Glass { .. } => return None,
                };
                Some(Event::Look(Look {
                    texture,
                    fragment: TexFragment {
                        d: direction.to_array(),
                        n: n.to_array(),
                        tangents,
                        st,
                    },
                    weight: weight * share * daylight(n),
                    bounce,
                }))
            };
            match finish {
                Finish::Lit { .. } => {
                    path.events.extend(look(1.0));
                    return;
                }
                Finish::Mirror => {
                    path.events.push(Event::Step(Step::Reflect(contact.curvature)));
                    direction = unit(direction.reflect(n));
                }
                Finish::Glass { index } => {
                    direction = self.through(index, &contact, direction, &mut random, path);
                }
                Finish::Glazed { lined, .. } if lined && !contact.outside => {
                    path.events.extend(look(1.0 - MATT));
                    path.events.push(Event::Step(Step::Reflect(contact.curvature)));
                    path.events.push(Event::Step(Step::Scatter(std::f64::consts::FRAC_1_PI)));
                    direction = scattered(n, &mut random);
                    weight *= MATT;
                }
                Finish::Glazed { share, .. } => {
                    path.events.extend(look(1.0 - share));
                    path.events.push(Event::Step(Step::Reflect(contact.curvature)));
                    direction = unit(direction.reflect(n));
                    weight *= share;
                }
            }
            origin = point;
            if weight < LEAST && self.only.is_none() {
                return;
            }
        }
    }

    /// The nearest contact and what its surface does.
    fn meet(&self, origin: DVec3, direction: DVec3) -> Option<(Contact, Finish)> {
        let mut nearest: Option<(Contact, Finish)> = None;
        for (shape, finish) in &self.surfaces {
            if let Some(contact) = shape.meet(origin, direction, BEYOND)
                && nearest.is_none_or(|(best, _)| contact.t < best.t)
            {
                nearest = Some((contact, *finish));
            }
        }
        nearest
    }

    /// Reflection or refraction at glass, with the cones' step.
    fn through(
        &self,
        index: f64,
        contact: &Contact,
        direction: DVec3,
        random: &mut Keyed,
        path: &mut Path,
    ) -> DVec3 {
        let cosine = direction.dot(contact.normal);
        let [outside, inside] = if contact.outside { [1.0, index] } else { [index, 1.0] };
        let bent = refract(direction, contact.normal, outside / inside);
        match bent {
            Some(bent) if random.number() >= fresnel(cosine.abs(), inside / outside, 0.0) => {
                path.events.push(Event::Step(Step::Refract {
                    curvature: contact.curvature,
                    outside,
                    inside,
                }));
                bent
            }
            Some(_) | None => {
                path.events.push(Event::Step(Step::Reflect(contact.curvature)));
                unit(direction.reflect(contact.normal))
            }
        }
    }

    /// What real rays see along one path: level 0 of the textures, the unfiltered environment.
    #[must_use]
    pub fn radiance(
        &self,
        path: &Path,
        texture: &dyn Fn(usize, [f64; 2]) -> [f64; 3],
        sky: &dyn Fn([f64; 3]) -> [f64; 3],
    ) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for event in &path.events {
            let (colour, weight) = match event {
                Event::Step(_) => continue,
                Event::Look(look) => (texture(look.texture, look.fragment.st), look.weight),
                Event::Sky { direction, weight } => (sky(*direction), *weight),
            };
            for (sum, c) in sum.iter_mut().zip(colour) {
                *sum += weight * c;
            }
        }
        sum
    }
}

/// Light on a surface: some from everywhere, more from above.
fn daylight(normal: DVec3) -> f64 {
    let sun = unit(dvec3(0.35, 0.85, 0.4));
    0.4 + 0.6 * normal.dot(sun).max(0.0)
}

/// A direction about the normal with a density of cos/π.
fn scattered(n: DVec3, random: &mut Keyed) -> DVec3 {
    let across = if n.x.abs() < 0.5 { DVec3::X } else { DVec3::Y };
    let a = unit(n.cross(across));
    let b = n.cross(a);
    let square = random.number();
    let turn = 2.0 * std::f64::consts::PI * random.number();
    let (radius, up) = (square.sqrt(), (1.0 - square).sqrt());
    let (x, y) = (radius * libm::cos(turn), radius * libm::sin(turn));
    unit(x * a + y * b + up * n)
}
