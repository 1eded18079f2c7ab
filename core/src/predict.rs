//! Sampled prediction of the vehicle (5.11–5.13).

use crate::candidate::Candidate;
use crate::state::Cursor;
use crate::{Dim, Health, Motion, Packed, Pose, PredictError, PredictReport, Real};

/// Splits every particle into `samples` candidates in the first prediction after a scan, then moves every candidate
/// with its own noise. A step of no length moves nothing and draws nothing. The moving features wait for the scan.
pub(crate) fn predict<T, M, const K: usize>(
    motion: &M,
    samples: usize,
    cursor: &mut Cursor<T>,
    candidates: &mut [Candidate<T, M::Pose>],
    control: &M::Control,
    dt: T,
) -> Result<PredictReport, PredictError>
where
    T: Real,
    M: Motion<T, K>,
    Dim<K>: Packed,
{
    let Some(mut noise) = cursor.noise.clone() else { return Err(PredictError::NotStarted) };
    let mut rejected = 0;
    if dt > T::ZERO {
        if !cursor.predicted {
            split(candidates, cursor.particles, samples);
            cursor.children = samples;
            cursor.predicted = true;
        }
        for candidate in candidates.iter_mut().take(cursor.candidates()) {
            let moved = motion.sample(&candidate.pose, control, dt, &mut noise);
            if moved.is_finite() {
                candidate.pose = moved;
            } else {
                rejected += 1;
            }
        }
        cursor.noise = Some(noise);
        cursor.waited_s += dt;
    }
    let health = Health::POSE_REJECTED.when(rejected > 0);
    Ok(PredictReport { candidates: cursor.candidates(), rejected, health })
}

/// M candidates ζ/M of every particle (5.13), in place, from the last particle back.
fn split<T: Real, P: Copy>(candidates: &mut [Candidate<T, P>], particles: usize, samples: usize) {
    let ln_samples = T::from_usize(samples).ln();
    for particle in (0..particles).rev() {
        let Some(&parent) = candidates.get(particle) else { continue };
        let first = particle * samples;
        for child in candidates.iter_mut().skip(first).take(samples) {
            *child = Candidate { pose: parent.pose, ln_weight: parent.ln_weight - ln_samples };
        }
    }
}
