//! Worlds of solid bodies that rays can be cast into: what surrounds a reflective object.
//!
//! A world answers what a ray from any point meets and how bright that is. Distance impostors
//! are made from it, and it is the truth that they are compared with. Surfaces glow by themselves:
//! radiance depends on the point alone, not on the direction, so that a filter's error is not mixed with a
//! shading model's.

pub mod bodies;
pub mod built_in;
pub mod light;
pub mod paint;

use std::fmt::Debug;
use std::sync::Arc;

use glam::DVec3;

use light::LightMap;
use paint::Paint;

/// Where a ray meets a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Meeting {
    /// The point is origin + t · direction; in units of the direction's length.
    pub t: f64,
    /// Unit normal that faces the ray's origin.
    pub normal: DVec3,
    /// Which of the body's parts: a side of a box, the mantle or a cap of a column.
    pub part: usize,
    /// Place on the part, in world units from its corner.
    pub place: [f64; 2],
}

/// A solid that rays can meet. A mesh is one as well as a sphere.
pub trait Body: Debug + Send + Sync {
    /// The first meeting with t > `beyond`, if there is one. `direction` has any length but zero.
    fn meet(&self, origin: DVec3, direction: DVec3, beyond: f64) -> Option<Meeting>;

    /// Width and height of every part, in world units, in the order of [`Meeting::part`].
    fn parts(&self) -> Vec<[f64; 2]>;
}

/// A body and its paint.
#[derive(Clone, Debug)]
pub struct Item {
    /// The solid.
    pub body: Arc<dyn Body>,
    /// How its surface glows.
    pub paint: Paint,
    /// Number of its first part among the world's walls.
    first_wall: usize,
}

/// The result of casting a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// Where, on which part.
    pub meeting: Meeting,
    /// The point.
    pub point: DVec3,
    /// Number of the part among all walls of the world.
    pub wall: usize,
    /// Place on the part, 0…1 each way: the address of a light map.
    pub uv: [f64; 2],
    /// Index of the item.
    item: usize,
}

/// Painted bodies.
#[derive(Clone, Debug, Default)]
pub struct World {
    items: Vec<Item>,
    walls: Vec<[f64; 2]>,
    /// The light that falls onto the walls in addition to their own glow.
    pub light: Option<Arc<LightMap>>,
}

impl World {
    /// The world with one more body.
    #[must_use]
    pub fn with(mut self, body: impl Body + 'static, paint: Paint) -> Self {
        let first_wall = self.walls.len();
        self.walls.extend(body.parts());
        self.items.push(Item { body: Arc::new(body), paint, first_wall });
        self
    }

    /// Width and height of every wall, in world units: the area of a light map.
    #[must_use]
    pub fn walls(&self) -> &[[f64; 2]] {
        &self.walls
    }

    /// The first hit of the ray origin + t · direction, t > 0; `None` where it escapes.
    #[must_use]
    pub fn look(&self, origin: DVec3, direction: DVec3) -> Option<Sight> {
        let mut nearest: Option<(usize, Meeting)> = None;
        for (index, item) in self.items.iter().enumerate() {
            if let Some(meeting) = item.body.meet(origin, direction, 0.0)
                && nearest.is_none_or(|(_, best)| meeting.t < best.t)
            {
                nearest = Some((index, meeting));
            }
        }
        let (index, meeting) = nearest?;
        let wall = self.items[index].first_wall + meeting.part;
        let [width, height] = self.walls.get(wall).copied().unwrap_or([1.0; 2]);
        Some(Sight {
            meeting,
            point: origin + meeting.t * direction,
            wall,
            uv: [meeting.place[0] / width, meeting.place[1] / height],
            item: index,
        })
    }

    /// Linear RGB of the place that was seen.
    #[must_use]
    pub fn glow(&self, sight: &Sight) -> [f64; 3] {
        let extent = self.walls.get(sight.wall).copied().unwrap_or([1.0; 2]);
        let glow =
            self.items[sight.item].paint.glow(sight.meeting.part, sight.meeting.place, extent);
        match &self.light {
            None => glow,
            Some(light) => {
                let lit = light.radiance(sight.wall, sight.uv, glow);
                [0, 1, 2].map(|i| glow[i] + lit[i])
            }
        }
    }

    /// Linear RGB along a ray; black where it escapes.
    #[must_use]
    pub fn radiance(&self, origin: DVec3, direction: DVec3) -> [f64; 3] {
        self.look(origin, direction).map_or([0.0; 3], |sight| self.glow(&sight))
    }
}
