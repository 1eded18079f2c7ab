//! Sampled prediction of the vehicle (5.11–5.13).

use crate::numerics::range::{is_within_range, is_within_square};
use crate::particles::candidate::Candidate;
use crate::particles::cursor::Cursor;
use crate::particles::short::{at_origin, is_short, propagated, short_beyond, summed};
use crate::{CovarianceOf, Health, Linearised, Motion, Noise, Pose, PredictError, PredictReport, Real, TangentOf};

/// Splits every particle into `samples` candidates in the first prediction after a scan, then moves every candidate with its own
/// noise. With `dt` = 0 it changes nothing and draws no random numbers. Moving features are predicted at the scan.
pub(crate) fn predict<T: Real, M: Motion<Pose: Pose<Scalar = T>>>(
    motion: &M,
    samples: usize,
    cursor: &mut Cursor<T>,
    candidates: &mut [Candidate<M::Pose>],
    control: &M::Control,
    dt: T,
) -> Result<PredictReport, PredictError> {
    let Some(mut noise) = cursor.noise.clone() else { return Err(PredictError::NotStarted) };
    let mut rejected = 0;
    if dt > T::ZERO {
        begin(samples, cursor, candidates, dt);
        let short_beyond = short_beyond(motion, control, dt);
        for candidate in candidates.iter_mut().take(cursor.candidates()) {
            rejected += usize::from(!sample(motion, candidate, control, dt, short_beyond, &mut noise));
        }
        cursor.noise = Some(noise);
    }
    Ok(report(cursor, rejected))
}

/// Prepares the sampling with `dt` > 0: the first prediction after a scan splits every particle into `samples` candidates (5.13).
pub(crate) fn begin<T: Real, P: Pose<Scalar = T>>(
    samples: usize,
    cursor: &mut Cursor<T>,
    candidates: &mut [Candidate<P>],
    dt: T,
) {
    if !cursor.predicted {
        split(candidates, cursor.particles, samples);
        cursor.children = samples;
        cursor.predicted = true;
    }
    cursor.wait(dt);
}

/// Moves one candidate with its own noise (5.12); `false`, without a change, if it would leave the range. Steps are
/// [short](crate::particles::short) beyond `short_beyond` from the origin, m.
#[inline]
pub(crate) fn sample<T: Real, M: Motion<Pose: Pose<Scalar = T>>>(
    motion: &M,
    candidate: &mut Candidate<M::Pose>,
    control: &M::Control,
    dt: T,
    short_beyond: T,
    noise: &mut Noise,
) -> bool {
    let Candidate { pose, remainder, .. } = candidate;
    // The motion is called in one place for both cases, because its code is large.
    let near = is_short(pose, short_beyond).then(|| at_origin(pose));
    let step = motion.sample(near.as_ref().unwrap_or(pose), control, dt, noise);
    let (moved, left) = if near.is_some() { summed(pose, *remainder, &step) } else { (step, *remainder) };
    let stays_in_range = is_within_range(&moved.coordinates());
    if stays_in_range {
        (*pose, *remainder) = (moved, left);
    }
    stays_in_range
}

/// Moves every particle without noise and increases the covariance of its pose, x ← f(x, u), P ← F P Fᵀ + Q: the prior of the
/// informed proposal at the scan. Draws no random numbers.
pub(crate) fn predict_gaussians<T: Real, M: Motion<Pose: Pose<Scalar = T>>>(
    motion: &M,
    cursor: &mut Cursor<T>,
    particles: &mut [Candidate<M::Pose>],
    pose_covariances: &mut [CovarianceOf<M::Pose>],
    control: &M::Control,
    dt: T,
) -> Result<PredictReport, PredictError> {
    if cursor.noise.is_none() {
        return Err(PredictError::NotStarted);
    }
    let mut rejected = 0;
    if dt > T::ZERO {
        let short_beyond = short_beyond(motion, control, dt);
        for (particle, pose_covariance) in particles.iter_mut().zip(pose_covariances.iter_mut()).take(cursor.particles)
        {
            rejected += usize::from(!grow(motion, particle, pose_covariance, control, dt, short_beyond));
        }
        cursor.predicted = true;
        cursor.wait(dt);
    }
    Ok(report(cursor, rejected))
}

/// Moves one particle without noise and increases the covariance of its pose; `false`, without a change, if one of them would leave
/// the range.
#[inline]
pub(crate) fn grow<T: Real, M: Motion<Pose: Pose<Scalar = T>>>(
    motion: &M,
    particle: &mut Candidate<M::Pose>,
    pose_covariance: &mut CovarianceOf<M::Pose>,
    control: &M::Control,
    dt: T,
    short_beyond: T,
) -> bool {
    let Candidate { pose, remainder, .. } = particle;
    let mut left = *remainder;
    let (moved, Linearised { transition, noise }) = if is_short(pose, short_beyond) {
        propagated(motion, pose, &mut left, control, dt)
    } else {
        (motion.propagate(pose, control, dt), motion.linearise(pose, control, dt))
    };
    let grown = pose_covariance.congruence::<TangentOf<M::Pose>>(&transition).plus(&noise);
    let stays_in_range = is_within_range(&moved.coordinates()) && is_within_square(&grown);
    if stays_in_range {
        *pose = moved;
        *remainder = left;
        *pose_covariance = grown;
    }
    stays_in_range
}

fn report<T: Real>(cursor: &Cursor<T>, rejected: usize) -> PredictReport {
    let refused = usize::from(cursor.refused);
    let health = Health::POSE_REJECTED.when(rejected > 0)
        | Health::PREDICTION_REFUSED.when(refused > 0)
        | cursor.watch.waiting(cursor.waited_s);
    PredictReport { candidates: cursor.candidates(), rejected, refused, health }
}

/// Replaces every particle by M candidates of weight ζ/M (5.13), in place, beginning with the last particle.
pub(crate) fn split<T: Real, P: Pose<Scalar = T>>(candidates: &mut [Candidate<P>], particles: usize, samples: usize) {
    let ln_samples = T::from_usize(samples).ln();
    for particle in (0..particles).rev() {
        let Some(&parent) = candidates.get(particle) else { continue };
        let first = particle * samples;
        for child in candidates.iter_mut().skip(first).take(samples) {
            *child = child_of(&parent, ln_samples);
        }
    }
}

/// One of the M candidates of a particle.
pub(crate) fn child_of<T: Real, P: Pose<Scalar = T>>(parent: &Candidate<P>, ln_samples: T) -> Candidate<P> {
    Candidate { ln_weight: parent.ln_weight - ln_samples, ..*parent }
}
