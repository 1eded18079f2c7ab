//! The launches of a scan, in their order: their names, and the number of their threads. All threads of a launch run the same stage,
//! for all filters, so that all threads of a device execute the same code.

use scphd::storage::{PART, TERMS};

/// Number of threads of a launch for each filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Places {
    One,
    Pages,
    /// One for some pages.
    PageParts,
    Candidates,
    Particles,
    /// One for each few dozen candidates.
    CandidateParts,
    /// One for each few dozen particles.
    ParticleParts,
    /// Several for each particle, which write its pages together.
    Lanes,
    /// One for each column of numbers that are summed.
    Columns,
    /// One and its [`HELPERS`], in a block of their own.
    Leader,
}

impl Places {
    /// The number of threads for a filter with these numbers of pages, with `particles` particles and `samples` samples of each.
    pub fn count(self, pages: [usize; 2], particles: usize, samples: usize) -> usize {
        match self {
            Self::One => 1,
            Self::Leader => HELPERS + 1,
            Self::Pages => pages.iter().sum(),
            Self::PageParts => page_parts(pages).iter().sum(),
            Self::Candidates => particles * samples,
            Self::Particles => particles,
            Self::Lanes => particles * LANES,
            Self::CandidateParts => (particles * samples).div_ceil(PART),
            Self::ParticleParts => particles.div_ceil(PART),
            Self::Columns => COLUMNS,
        }
    }
}

/// Number of threads that write the pages of a draft together, word by word.
pub(crate) const LANES: usize = 32;
/// Columns of `f32` with one number for each particle, which are summed in order: the terms of the drafts, the weight, the terms of
/// the mean pose (x, y, sine and cosine of the heading), those of its covariance, and those of the particles' own covariances.
pub(crate) const WEIGHT: usize = TERMS;
pub(crate) const CENTRE: usize = WEIGHT + 1;
pub(crate) const SPREAD: usize = CENTRE + 4;
pub(crate) const BLUR: usize = SPREAD + 6;
/// Number of these columns.
pub(crate) const COLUMNS: usize = BLUR + 6;

/// Numbers of parts of the pages of static features, and of those of moving ones.
pub(crate) fn page_parts(pages: [usize; 2]) -> [usize; 2] {
    pages.map(|pages| pages.div_ceil(pages_together(pages)))
}

/// Number of pages that one thread counts: about the square root, so that there are as many of these threads.
pub(crate) fn pages_together(pages: usize) -> usize {
    1 << (pages.max(1).ilog2() / 2)
}

/// Number of threads that help the leader of a block.
pub const HELPERS: usize = 32;

/// Passes the launches to another macro: those that start the filters, those of each prediction before a scan, that of a requested
/// predicted pose, those of a scan, and that of a requested digest. Each has its function, after which its kernel is named, and its threads for each filter.
macro_rules! launches {
    ($then:ident! { $($with:tt)* }) => {
        $then! {
            $($with)*
            {
                stages::start One; // Starts the filters.
                stages::furnish Particles; // Makes a draft over each desk.
            }
            {
                stages::predict One; // Begins the next prediction before a scan.
                stages::sample Candidates; // Moves the candidates (5.12), or the particles of an informed proposal.
            }
            {
                stages::forecast One; // Estimates the predicted pose.
            }
            {
                stages::open One; // Sorts the measurements.
                stages::drift Pages; // Predicts the moving features (5.14), resets the numbers of maps that hold a page, and copies the particles.
                stages::line_up One; // Moves the random stream behind the numbers of an informed proposal.
                stages::propose Particles; // Draws the candidates of an informed proposal.
                stages::weigh Candidates; // Weighs the candidates (4.52).
                select::products CandidateParts; // Sums ζ L over parts of the candidates.
                select::evidence One; // Adds these sums up.
                select::multiply CandidateParts; // Multiplies the weights by the likelihoods (5.23).
                select::rest One; // Computes the divisor that the weights still need.
                select::cumulate CandidateParts; // Divides the weights by it, and computes their cumulative sums in parts.
                select::decide One; // Decides whether to resample.
                select::draw Particles; // Draws the survivors (5.2.2).
                select::runs ParticleParts; // Counts the different survivors, and finds the heaviest, in parts.
                select::settle One; // Begins the update of the survivors' maps.
                select::assign ParticleParts; // Assigns a draft to each different survivor.
                store::make Particles; // Updates the survivors' maps (5.17–5.22), each in its draft.
                store::claim ParticleParts; // Sums the labels and pages that the drafts allocate, in parts.
                store::unheld PageParts; // Counts the pages that no map holds any more, in parts.
                store::add_up One; // Adds these sums up.
                store::judge ParticleParts; // Finds the positions of each draft's labels and pages, and whether there are enough pages.
                store::commit One; // Lends the lists of pages; if there are too few pages, stores the drafts one after the other.
                store::list PageParts; // Lists the free pages.
                store::take Particles; // Allocates pages and labels for the drafts.
                store::fill Lanes; // Writes the pages.
                store::share Particles; // Gives every particle the list of its pages, and moves its candidate to the particle's place.
                tell::sum Columns; // Sums over drafts and particles.
                tell::centre Particles; // Computes the terms of the mean pose.
                tell::sum_centre Columns; // Adds them up.
                tell::spread Particles; // Computes the terms of the covariance of the pose.
                tell::sum_spread Columns; // Adds them up.
                tell::close One; // Writes estimates and report.
            }
            {
                tell::digest One; // Computes the digest of the state after a scan, if it is requested.
            }
        }
    };
}

#[cfg(target_arch = "nvptx64")]
pub(crate) use launches;

/// Lists of the launches.
macro_rules! lists {
    ($({ $($file:ident::$body:ident $places:ident;)* })+) => {
        [$(&[$((stringify!($body), Places::$places)),*]),+]
    };
}

/// Names and threads of the launches: those that start the filters, those of each prediction, that of a predicted pose, those of a
/// scan, and that of a digest. The name of a kernel has the prefix `scphd_many_`, `scphd_large_` or `scphd_joint_`.
pub type Lists = [&'static [(&'static str, Places)]; 5];

/// The launches of filters with particles.
pub const LAUNCHES: Lists = launches!(lists! {});
/// The launches of joint maps, whose predictions are a part of the scan.
pub const JOINT_LAUNCHES: Lists = lists! { { joint::start One; } {} {} { joint::scan Leader; } { joint::digest One; } };
