//! The cases of the stages that follow from their operands alone: the reference's stage at f32 operands says what a kernel
//! must make of the same words.

use super::{Bounded, Case, Expected};
use crate::base::num;
use crate::engine::gpu::bit;
use crate::gpu::kernels::{Kernel, Register};
use crate::gpu::policy::to_f32;
use crate::reference::cube_face::Facing;
use crate::reference::footprint::Footprint;
use crate::reference::local_frame::Frame;
use crate::reference::reflect::Reflection;
use crate::reference::{Flag, Flags, Tap};
use crate::stage::Stage;

/// The values passed from one stage to the next.
pub(super) trait Operand {
    /// Appends the words that a kernel takes.
    fn put(&self, words: &mut Vec<u32>);

    /// The same as the next stage gets it: rounded to f32.
    #[must_use]
    fn rounded(self) -> Self;
}

impl Operand for Bounded {
    fn put(&self, words: &mut Vec<u32>) {
        words.push(to_f32(self.value).to_bits());
    }

    fn rounded(self) -> Self {
        Self::exact(f64::from(to_f32(self.value)))
    }
}

impl Operand for u32 {
    fn put(&self, words: &mut Vec<u32>) {
        words.push(*self);
    }

    fn rounded(self) -> Self {
        self
    }
}

impl Operand for usize {
    fn put(&self, words: &mut Vec<u32>) {
        words.push(num::u32(*self));
    }

    fn rounded(self) -> Self {
        self
    }
}

/// Words that are put together already.
impl Operand for &[u32] {
    fn put(&self, words: &mut Vec<u32>) {
        words.extend_from_slice(self);
    }

    fn rounded(self) -> Self {
        self
    }
}

impl<T: Operand, const N: usize> Operand for [T; N] {
    fn put(&self, words: &mut Vec<u32>) {
        self.iter().for_each(|x| x.put(words));
    }

    fn rounded(self) -> Self {
        self.map(T::rounded)
    }
}

/// Operands one after the other.
macro_rules! tuples {
    ($(($($name:ident)+))+) => {$(
        impl<$($name: Operand),+> Operand for ($($name,)+) {
            fn put(&self, words: &mut Vec<u32>) {
                #[expect(non_snake_case, reason = "a part is called by its type")]
                let ($($name,)+) = self;
                $($name.put(words);)+
            }

            fn rounded(self) -> Self {
                #[expect(non_snake_case, reason = "a part is called by its type")]
                let ($($name,)+) = self;
                ($($name.rounded(),)+)
            }
        }
    )+};
}

tuples! { (A B) (A B C) (A B C D) (A B C D E) (A B C D E F) (A B C D E F G) }

/// Results of the reference: the fields that a kernel takes, and those that only a part of the kernels takes.
macro_rules! results {
    ($($name:ident { $($field:ident),+; $($apart:ident),* })+) => {$(
        impl Operand for $name<Bounded> {
            fn put(&self, words: &mut Vec<u32>) {
                $(self.$field.put(words);)+
            }

            fn rounded(self) -> Self {
                Self {
                    $($field: self.$field.rounded(),)+
                    $($apart: self.$apart.rounded(),)*
                }
            }
        }
    )+};
}

results! {
    Frame { h, direction, inv_length, n_length; e1, e2 }
    Reflection { n_dot_v, n_dot_n; v_r }
    Facing { face, inv_ma, u, v; }
    Footprint { step, probes, lod; }
}

/// Doubles as a kernel gets them.
pub(super) fn ports<const N: usize>(v: [f64; N]) -> [Bounded; N] {
    v.map(|x| Bounded::exact(x).rounded())
}

/// The registers of one fragment at one stage, with their errors, as the reference puts them.
#[derive(Clone, Debug, Default)]
pub(super) struct Recorder {
    pub(super) put: Vec<(&'static str, usize, f64, f64)>,
}

impl Tap for Recorder {
    fn put(&mut self, stage: Stage, register: &'static str, component: usize, value: f64) {
        self.put_with_error(stage, register, component, value, 0.0);
    }

    fn put_with_error(
        &mut self,
        _: Stage,
        register: &'static str,
        component: usize,
        value: f64,
        error: f64,
    ) {
        self.put.push((register, component, value, error));
    }

    fn event(&mut self, _: &'static str) {}
}

impl Recorder {
    fn get(&self, register: &str, component: usize) -> Expected {
        self.put
            .iter()
            .find(|(name, c, ..)| *name == register && *c == component)
            .map(|(_, _, value, error)| (*value, *error))
    }

    /// The words of a kernel that writes `registers`.
    fn expected(&self, registers: &[Register]) -> Vec<Expected> {
        let words = registers.iter().flat_map(|r| (0..r.words).map(|c| (r.name, c)));
        words.map(|(name, c)| self.get(name, c)).collect()
    }

    pub(super) fn add(&mut self, register: &'static str, value: u32) {
        self.put.push((register, 0, value.into(), 0.0));
    }

    fn flags(&mut self, flags: Flags) {
        let bits = Flag::ALL
            .into_iter()
            .filter(|flag| flags.contains(*flag))
            .fold(0, |bits, flag| bits | bit(flag));
        self.add("flags", bits);
    }
}

/// The cases of some fragments, by stage.
pub(super) struct Cases {
    /// The pixel of the fragment that is put together.
    pub(super) pixel: [u32; 2],
    /// By the stage's place in the pipeline.
    pub(super) stages: [(Vec<Register>, Vec<Case>); Stage::ALL.len()],
}

impl Default for Cases {
    fn default() -> Self {
        let registers = |stage| Kernel::Stage(stage).registers(0);
        Self { pixel: [0; 2], stages: Stage::ALL.map(|stage| (registers(stage), Vec::new())) }
    }
}

impl Cases {
    /// Adds a stage's case: `work` is the reference's stage at `operands`. Returns its results as the next stage gets them.
    pub(super) fn stage<T: Operand>(
        &mut self,
        stage: Stage,
        operands: impl Operand,
        work: impl FnOnce(&mut Recorder, &mut Flags) -> T,
    ) -> T {
        let mut recorder = Recorder::default();
        let mut flags = Flags::default();
        let _ = Bounded::undecided();
        let out = work(&mut recorder, &mut flags);
        let undecided = Bounded::undecided() > 0;
        recorder.flags(flags);
        let mut words = Vec::new();
        operands.put(&mut words);
        let (registers, cases) = &mut self.stages[stage as usize];
        let expected = recorder.expected(registers);
        cases.push(Case { pixel: self.pixel, operands: words, expected, undecided });
        out.rounded()
    }
}
