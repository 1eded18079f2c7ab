//! The filter under RTIC 2: odometry, sensor and estimator as tasks of different priorities.
#![no_std]
#![no_main]

#[rtic::app(device = scphd_firmware_rtos::device, peripherals = false)]
mod app {
    use heapless::spsc::{Consumer, Producer, Queue};
    use rtic::pend;
    use scphd_firmware_rtos::device::Interrupt;
    use scphd_firmware_rtos::drive::{Sample, Scan, Sensor, Wheels};
    use scphd_firmware_rtos::estimator::{Estimator, stream};
    use scphd_firmware_rtos::tally::TALLY;
    use scphd_firmware_rtos::timer::Timer;

    /// Capacity of the queue of odometry samples, plus one.
    const SAMPLES: usize = 17;
    /// Capacity of the queue of scans, plus one.
    const SCANS: usize = 3;
    /// The interrupt of the estimator, pended by software only, after an input was queued. If it is pended while its task runs,
    /// the task runs again, so that no input is missed.
    const ESTIMATE: Interrupt = Interrupt::DUAL_TIMER;

    #[shared]
    struct Shared {}

    #[local]
    struct Local {
        odometry_timer: Timer,
        wheels: Wheels,
        samples_in: Producer<'static, Sample>,
        sensor_timer: Timer,
        sensor: Sensor,
        scans_in: Producer<'static, Scan>,
        samples: Consumer<'static, Sample>,
        scans: Consumer<'static, Scan>,
        estimator: Estimator,
    }

    #[init(local = [
        of_samples: Queue<Sample, SAMPLES> = Queue::new(),
        of_scans: Queue<Scan, SCANS> = Queue::new(),
    ])]
    fn init(context: init::Context) -> (Shared, Local) {
        let (samples_in, samples) = context.local.of_samples.split();
        let (scans_in, scans) = context.local.of_scans.split();
        // SAFETY: this runs once, and nothing else uses timers or lights.
        let (mut odometry_timer, mut sensor_timer, estimator) =
            unsafe { (Timer::first(), Timer::second(), Estimator::start()) };
        let (wheels, sensor) = (Wheels::of(stream()), Sensor::of(stream()));
        wheels.due().into_iter().for_each(|ticks| odometry_timer.start(ticks));
        sensor.due().into_iter().for_each(|ticks| sensor_timer.start(ticks));
        let local =
            Local { odometry_timer, wheels, samples_in, sensor_timer, sensor, scans_in, samples, scans, estimator };
        (Shared {}, local)
    }

    /// Reads an odometry sample when its timer expires. Preempts all other tasks.
    #[task(binds = TIMER0, priority = 3, local = [odometry_timer, wheels, samples_in])]
    fn odometry(context: odometry::Context) {
        let odometry::LocalResources { odometry_timer, wheels, samples_in, .. } = context.local;
        TALLY.interrupted(odometry_timer.expired());
        if let Some(sample) = wheels.sample() {
            if samples_in.enqueue(sample).is_err() {
                TALLY.lost_odometry();
            }
            TALLY.waiting(samples_in.len());
        }
        match wheels.due() {
            Some(ticks) => odometry_timer.again(ticks),
            None => odometry_timer.stop(),
        }
        pend(ESTIMATE);
    }

    /// Receives a scan when its timer expires.
    #[task(binds = TIMER1, priority = 2, local = [sensor_timer, sensor, scans_in])]
    fn receive(context: receive::Context) {
        let receive::LocalResources { sensor_timer, sensor, scans_in, .. } = context.local;
        sensor_timer.expired();
        if let Some(scan) = sensor.scan()
            && scans_in.enqueue(scan).is_err()
        {
            TALLY.lost_scan();
        }
        match sensor.due() {
            Some(ticks) => sensor_timer.again(ticks),
            None => {
                sensor_timer.stop();
                TALLY.end();
            }
        }
        pend(ESTIMATE);
    }

    /// Runs the filter on waiting inputs.
    #[task(binds = DUAL_TIMER, priority = 1, local = [samples, scans, estimator])]
    fn estimate(context: estimate::Context) {
        let estimate::LocalResources { samples, scans, estimator, .. } = context.local;
        // Read before the queues, so that these have every input if the drive has ended.
        let ended = TALLY.has_ended();
        estimator.work(|| scans.dequeue(), || samples.dequeue());
        if ended {
            estimator.end();
        }
    }

    /// A board should execute `wfi` here. QEMU wakes a sleeping processor late if several timers expire, and runs would not be
    /// reproducible.
    #[idle]
    fn idle(_: idle::Context) -> ! {
        loop {
            cortex_m::asm::nop();
        }
    }
}

scphd_firmware::failure_handlers!();
