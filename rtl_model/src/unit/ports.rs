//! From the words of fragments to the registers behind the ports.

use super::Unit;
use super::block::{NO_FLAGS, Ports, State, Words};
use crate::lanes::LaneSink;
use crate::port::{scalar_lanes, vector_lanes};
use crate::regs::{Event, Register};
use crate::stages::Lanes;
use crate::tap::Tap;

impl Unit {
    /// Puts the words of one fragment into a lane.
    #[inline(always)]
    pub(super) fn put_words<const N: usize>(
        &self,
        words: &Words,
        ports: &mut Ports<N>,
        lane: usize,
    ) {
        let put = |to: &mut [[u64; N]], from: &[u64]| {
            for (to, from) in to.iter_mut().zip(from) {
                to[lane] = *from;
            }
        };
        put(&mut ports.v, &words.v);
        put(&mut ports.n, &words.n);
        put(&mut ports.dv, words.dv.as_flattened());
        put(&mut ports.dn, words.dn.as_flattened());
        if self.bump.is_some() {
            put(&mut ports.b, &words.b);
        }
        if self.roughness.is_some() {
            put(&mut ports.d, &words.d);
        }
        if self.frame.is_some() {
            put(&mut ports.h, &words.h);
        }
    }

    /// The ports: n, v and h normalised, everything else written to its register.
    #[inline(always)]
    pub fn ports<const N: usize, T: Tap>(
        &self,
        ports: &Ports<N>,
        state: &mut State<N>,
        tap: &mut T,
    ) {
        state.flags = [NO_FLAGS; N];
        let input = &mut state.input;
        let mut finite = [true; N];
        let flags = &mut state.flags[..state.len];
        let mut sink = LaneSink::<N, T>::new(flags, tap);
        let n = self.frame.as_ref().map_or(&self.reflect.n, |frame| &frame.n);
        let v = &self.reflect.v;
        vector(&mut sink, v, &ports.v, &mut finite, &mut input.v, &mut input.v_exp);
        vector(&mut sink, n, &ports.n, &mut finite, &mut input.n, &mut input.n_exp);
        for col in 0..2 {
            let (dv, dn) = (&self.jacobian.dv[col], &self.normal.dn[col]);
            for c in 0..3 {
                let k = 3 * col + c;
                scalar(&mut sink, dv, c, &ports.dv[k], &input.v_exp, &mut finite, &mut input.dv[k]);
                scalar(&mut sink, dn, c, &ports.dn[k], &input.n_exp, &mut finite, &mut input.dn[k]);
            }
        }
        if let Some(bump) = &self.bump {
            for (c, b) in input.b.iter_mut().enumerate() {
                scalar(&mut sink, &bump.b, c, &ports.b[c], &[0; N], &mut finite, b);
            }
        }
        if let Some(rough) = &self.roughness {
            for (c, d) in input.d.iter_mut().enumerate() {
                scalar(&mut sink, &rough.d, c, &ports.d[c], &[0; N], &mut finite, d);
            }
        }
        if let Some(frame) = &self.frame {
            vector(&mut sink, &frame.h, &ports.h, &mut finite, &mut input.h, &mut input.h_exp);
        }
        let mut not_finite = [false; N];
        for (not, finite) in not_finite.iter_mut().zip(&finite) {
            *not = !finite;
        }
        sink.event(Event::InputNotFinite, &not_finite);
    }
}

/// A port of a vector: mantissas, and the power of two that was taken out.
#[inline(always)]
fn vector<const N: usize, T: Tap>(
    sink: &mut LaneSink<'_, N, T>,
    q: &Register,
    words: &[[u64; N]; 3],
    finite: &mut [bool; N],
    out: &mut Lanes<N, 3>,
    exp: &mut [i64; N],
) {
    vector_lanes(sink.n, q, words, finite, out, exp);
    for (c, m) in out.iter().enumerate() {
        sink.put(q, c, m, |i| exp[i]);
    }
    let nominal = q.block_frac();
    for exp in &mut exp[..sink.n] {
        *exp = nominal - *exp;
    }
}

/// A port of a number.
#[inline(always)]
fn scalar<const N: usize, T: Tap>(
    sink: &mut LaneSink<'_, N, T>,
    q: &Register,
    c: usize,
    words: &[u64; N],
    exponent: &[i64; N],
    finite: &mut [bool; N],
    out: &mut [i64; N],
) {
    scalar_lanes(sink.n, q, words, exponent, finite, sink.flags, out);
    sink.put(q, c, out, |i| q.frac() - exponent[i]);
}
