//! Launches of small kernels whose results and counts can be computed by hand.

use scphd_ptx::{Counts, Fault, Grid, LaunchError, Memory, Module};

/// A module with these kernels and functions.
fn module(text: &str, memory: &mut Memory) -> Module {
    Module::read(&format!(".version 7.0\n.target sm_80\n.address_size 64\n{text}"), memory).unwrap()
}

/// A kernel with one pointer. `%rd1` is the address of the thread's number, `%r1` its index, `%rd2` the pointer.
fn kernel(body: &str) -> String {
    format!(
        ".visible .entry k(.param .u64 .ptr .align 1 k_param_0) {{
            .reg .pred %p<4>; .reg .b32 %r<9>; .reg .b64 %rd<9>;
            ld.param.b64 %rd2, [k_param_0];
            mov.u32 %r2, %ctaid.x; mov.u32 %r3, %ntid.x; mov.u32 %r4, %tid.x;
            mad.lo.s32 %r1, %r2, %r3, %r4;
            mul.wide.u32 %rd3, %r1, 4;
            add.s64 %rd1, %rd2, %rd3;
            {body}
        }}"
    )
}

/// Number of instructions of [`kernel`] before its body.
const BEFORE: u64 = 7;

fn grid(threads: u32) -> Grid {
    Grid { blocks: 1, block: threads }
}

fn numbers(memory: &Memory, at: u64) -> Vec<u32> {
    let bytes = memory.bytes(at).chunks_exact(4);
    bytes.map(|bytes| u32::from_le_bytes(bytes.try_into().unwrap())).collect()
}

/// Runs the kernel on a buffer with one number for each thread. Returns the numbers and the counts.
fn run(text: &str, grid: Grid) -> (Vec<u32>, Counts) {
    let mut memory = Memory::default();
    memory.watch();
    let module = module(text, &mut memory);
    let at = memory.allocate(vec![0; 4 * (grid.blocks * grid.block) as usize]);
    let counts = module.launch("k", grid, &[at], &mut memory).unwrap();
    (numbers(&memory, at), counts)
}

fn refused(text: &str, grid: Grid, bytes: usize) -> LaunchError {
    let mut memory = Memory::default();
    memory.watch();
    let module = module(text, &mut memory);
    let at = memory.allocate(vec![0; bytes]);
    module.launch("k", grid, &[at], &mut memory).unwrap_err()
}

#[test]
fn a_grid_runs_every_thread_once() {
    let text = kernel("add.s32 %r5, %r1, 100; st.global.b32 [%rd1], %r5; ret;");
    let expected: Vec<u32> = (100..250).collect();
    let (found, counts) = run(&text, Grid { blocks: 3, block: 50 });
    assert_eq!(found, expected);
    // Three blocks, each with a whole warp and one of 18 threads.
    assert_eq!(counts.warp_instructions, 6 * (BEFORE + 3));
    assert_eq!(counts.longest_warp, BEFORE + 3);
}

#[test]
fn diverged_threads_take_both_paths_and_reconverge() {
    let text = kernel(
        "and.b32 %r5, %r1, 1; setp.ne.b32 %p1, %r5, 0;
         @%p1 bra $odd;
         mov.b32 %r6, 7; add.s32 %r6, %r6, %r1; bra.uni $both;
         $odd: mul.lo.s32 %r6, %r1, 3;
         $both: st.global.b32 [%rd1], %r6; ret;",
    );
    let (found, counts) = run(&text, grid(32));
    assert!(found.iter().zip(0..).all(|(&value, place)| value == if place % 2 == 1 { 3 * place } else { 7 + place }));
    // The path of even threads has 3 instructions, the other 1; both continue with the last two.
    assert_eq!(counts.warp_instructions, BEFORE + 3 + 3 + 1 + 2);
}

#[test]
fn a_loop_takes_as_long_as_its_longest_thread() {
    let text = kernel(
        "mov.b32 %r5, 0;
         $more: setp.ge.u32 %p1, %r5, %r1;
         @%p1 bra $done;
         add.s32 %r5, %r5, 1; bra.uni $more;
         $done: st.global.b32 [%rd1], %r5; ret;",
    );
    let (found, counts) = run(&text, grid(20));
    assert_eq!(found, (0..20).collect::<Vec<u32>>());
    assert_eq!(counts.warp_instructions, BEFORE + 1 + 4 * 19 + 2 + 2);
}

#[test]
fn returned_threads_are_not_waited_for() {
    let text = kernel(
        "setp.lt.u32 %p1, %r1, 8; @%p1 bra $on; ret;
         $on: st.global.b32 [%rd1], 5; ret;",
    );
    let (found, counts) = run(&text, grid(12));
    assert_eq!(found, [5, 5, 5, 5, 5, 5, 5, 5, 0, 0, 0, 0]);
    assert_eq!(counts.warp_instructions, BEFORE + 2 + 1 + 2);
    // The same with a negated guard.
    let text = kernel("setp.lt.u32 %p1, %r1, 8; @!%p1 bra $end; st.global.b32 [%rd1], 5; $end: ret;");
    assert_eq!(run(&text, grid(12)).0, found);
}

#[test]
fn a_switch_splits_into_one_path_for_each_target() {
    let text = kernel(
        "and.b32 %r5, %r1, 3;
         $list: .branchtargets $zero, $other, $two, $other;
         brx.idx %r5, $list;
         $zero: mov.b32 %r6, 10; bra.uni $all;
         $two: mov.b32 %r6, 12; bra.uni $all;
         $other: mov.b32 %r6, 99;
         $all: st.global.b32 [%rd1], %r6; ret;",
    );
    let (found, counts) = run(&text, grid(8));
    assert_eq!(found, [10, 99, 12, 99, 10, 99, 12, 99]);
    assert_eq!(counts.warp_instructions, BEFORE + 2 + 2 + 2 + 1 + 2);
    let beyond = kernel("$list: .branchtargets $a; brx.idx %r1, $list; $a: ret;");
    assert!(matches!(refused(&beyond, grid(2), 8), LaunchError::Fault { thread: 1, fault: Fault::Switch, .. }));
}

#[test]
fn endless_calls_are_refused() {
    let function = ".func deep(.param .b32 deep_param_0);
        .func deep(.param .b32 deep_param_0) { { .param .b32 param0; call.uni deep, (param0); } ret; }";
    let text = function.to_owned() + &kernel("{ .param .b32 param0; call.uni deep, (param0); } ret;");
    assert!(matches!(refused(&text, grid(1), 4), LaunchError::Fault { fault: Fault::TooDeep, .. }));
}

#[test]
fn invalid_accesses_are_refused() {
    let of = |body: &str| match refused(&kernel(body), grid(4), 12) {
        LaunchError::Fault { thread, fault, .. } => (thread, fault),
        error => panic!("{error}"),
    };
    assert!(matches!(of("st.global.b32 [%rd1], 5; ret;"), (3, Fault::Outside(_))));
    assert!(matches!(of("ld.b32 %r5, [%rd1+2]; ret;"), (0, Fault::Unaligned(_))));
    assert!(matches!(of("ld.v2.b32 {%r5, %r6}, [%rd2+4]; ret;"), (0, Fault::Unaligned(_))));
    assert!(matches!(of("ld.local.b32 %r5, [%rd1]; ret;"), (0, Fault::Space(_))));
    assert!(matches!(of("mov.b64 %rd4, 0; ld.b32 %r5, [%rd4]; ret;"), (0, Fault::Outside(0))));
}

#[test]
fn two_threads_at_one_place_are_refused_if_one_writes() {
    let of = |body: &str| refused(&kernel(body), grid(4), 16);
    let race = |error| matches!(error, LaunchError::Fault { fault: Fault::Race(_), .. });
    assert!(race(of("st.global.b32 [%rd2], 5; ret;")));
    assert!(race(of("ld.b32 %r5, [%rd2]; setp.eq.b32 %p1, %r1, 0; @%p1 bra $one; ret; $one: st.b32 [%rd2], 1; ret;")));
    // All may read one place, and change it atomically.
    let (found, _) = run(&kernel("atom.max.u32 %r5, [%rd2], %r1; ret;"), grid(4));
    assert_eq!(found, [3, 0, 0, 0]);
}

#[test]
fn warps_of_a_block_wait_for_each_other_at_a_barrier() {
    // The last thread, alone in its warp, reads after the barrier what the first warp has written, then writes what that one reads.
    let text = kernel(
        "setp.eq.b32 %p1, %r1, 32; @%p1 bra $last;
         st.global.b32 [%rd1], %r1; bar.sync 0; bar.sync 0;
         ld.b32 %r5, [%rd2+128]; st.global.b32 [%rd1], %r5; ret;
         $last: bar.sync 0; ld.b32 %r5, [%rd2+124]; add.s32 %r5, %r5, 7; st.global.b32 [%rd1], %r5; bar.sync 0; ret;",
    );
    let (found, counts) = run(&text, Grid { blocks: 1, block: 33 });
    assert_eq!(found, [38; 33]);
    // Up to the first barrier the first warp is slower, then the last thread, then the first warp again.
    assert_eq!(counts.longest_warp, BEFORE + 4 + 4 + 3);
    let some = kernel("setp.eq.b32 %p1, %r1, 0; @%p1 bra $end; bar.sync 0; $end: ret;");
    assert!(matches!(refused(&some, grid(2), 8), LaunchError::Fault { fault: Fault::Barrier, .. }));
}

#[test]
fn invalid_launches_are_refused() {
    let mut memory = Memory::default();
    let module = module(&kernel("ret;"), &mut memory);
    for (name, grid, arguments) in [("other", grid(1), &[0][..]), ("k", grid(1), &[]), ("k", grid(0), &[0])] {
        assert!(matches!(module.launch(name, grid, arguments, &mut memory), Err(LaunchError::Launch(..))));
    }
}

#[test]
fn unknown_instructions_are_refused_with_their_line() {
    for (body, line, what) in [
        ("fma.rn.f32 %r5, %r5, %r5, %r5;\nret;", 12, "fma.rn.f32"),
        ("@%p1 ret;", 12, "ret"),
        ("bra $nowhere;", 12, "$nowhere"),
        ("mov.b32 %r1, somewhere;", 12, "somewhere"),
        ("{ call.uni missing, (); }", 12, "missing"),
        ("ld.global.f64x %rd1, [%rd2];", 12, "f64x"),
    ] {
        let text = format!(".version 7.0\n.target sm_80\n.address_size 64\n\n{}", kernel(body));
        let error = Module::read(&text, &mut Memory::default()).unwrap_err();
        assert_eq!(error.line, line, "{error}");
        assert!(error.what.contains(what), "{error}");
    }
}
