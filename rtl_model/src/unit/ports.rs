//! From the words of fragments to the registers behind the ports.

use lanes::Vector;

use super::Unit;
use super::block::{Inputs, Ports, Words};
use crate::lanes::Writes;
use crate::regs::{Event, Register};

impl Unit {
    /// The ports: n, v and h normalised, everything else written to its register.
    #[inline(always)]
    pub(super) fn through<V: Vector>(
        &self,
        words: &Ports<V>,
        sink: &mut impl Writes<V>,
    ) -> Inputs<V> {
        let none = words.v[0].like(0);
        let mut finite = none.zero();
        let n = self.frame.as_ref().map_or(&self.reflect.n, |frame| &frame.n);
        let (v, v_exp) = vector(sink, &self.reflect.v, words.v, &mut finite);
        let (n, n_exp) = vector(sink, n, words.n, &mut finite);
        let (mut dv, mut dn) = (words.dv, words.dn);
        for k in 0..6 {
            let (q, c) = (&self.jacobian.dv[k / 3], k % 3);
            dv[k] = sink.number(q, c, dv[k], v_exp, &mut finite);
            dn[k] = sink.number(&self.normal.dn[k / 3], c, dn[k], n_exp, &mut finite);
        }
        let (mut b, mut d, mut h, mut h_exp) = ([none; 2], [none; 3], [none; 3], none);
        if let Some(bump) = &self.bump {
            for c in 0..2 {
                b[c] = sink.number(&bump.b, c, words.b[c], none, &mut finite);
            }
        }
        if let Some(rough) = &self.roughness {
            for c in 0..3 {
                d[c] = sink.number(&rough.d, c, words.d[c], none, &mut finite);
            }
        }
        if let Some(frame) = &self.frame {
            (h, h_exp) = vector(sink, &frame.h, words.h, &mut finite);
        }
        sink.event(Event::InputNotFinite, !finite);
        Inputs { v, v_exp, n, n_exp, h, h_exp, dv, dn, b, d }
    }

    /// Puts the words of one fragment into a lane.
    #[inline(always)]
    pub(super) fn put_words<const N: usize>(
        &self,
        words: &Words,
        to: &mut Ports<[i64; N]>,
        lane: usize,
    ) {
        put(&mut to.v, &words.v, lane);
        put(&mut to.n, &words.n, lane);
        put(&mut to.dv, words.dv.as_flattened(), lane);
        put(&mut to.dn, words.dn.as_flattened(), lane);
        if self.bump.is_some() {
            put(&mut to.b, &words.b, lane);
        }
        if self.roughness.is_some() {
            put(&mut to.d, &words.d, lane);
        }
        if self.frame.is_some() {
            put(&mut to.h, &words.h, lane);
        }
    }
}

#[inline(always)]
fn put<const N: usize>(to: &mut [[i64; N]], from: &[u64], lane: usize) {
    for (to, from) in to.iter_mut().zip(from) {
        to[lane] = from.cast_signed();
    }
}

/// A port of a vector: mantissas, and the power of two that was taken out.
#[inline(always)]
fn vector<V: Vector>(
    sink: &mut impl Writes<V>,
    q: &Register,
    words: [V; 3],
    finite: &mut V::Mask,
) -> ([V; 3], V) {
    let (m, frac) = sink.vector(q, words, finite);
    (m, frac.like(q.block_frac()) - frac)
}
