//! A flight has one hash, whatever the number of jobs and repetitions.

use std::path::Path;

use twin_scenario::Report;
use twin_scenario::suite::{CaseResult, Options, Plan, Selection, plan, run};

fn short(seeds: Vec<u64>, iterations: usize) -> Plan {
    let hover = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/hover.toml");
    let overrides = ["task.duration_s=0.5", "wind.kind=dryden"].map(str::to_owned).to_vec();
    let paths = vec![hover.display().to_string()];
    plan(&Selection { paths, seeds, iterations, overrides, ..Selection::default() })
        .expect("the scenario is there")
}

fn report(result: &CaseResult) -> &Report {
    result.report().unwrap_or_else(|| panic!("{result:?}"))
}

#[test]
fn the_number_of_jobs_changes_no_hash_and_repeats_agree() {
    let plan = short(vec![1, 2, 3], 2);
    let hashes = |jobs| {
        let results = run(&plan, &Options { jobs, ..Options::default() }, &|_| {}).cases;
        assert!(results.iter().all(CaseResult::passed));
        results.iter().map(|result| report(result).state_hash.clone()).collect::<Vec<_>>()
    };
    let (one, four) = (hashes(1), hashes(4));
    assert_eq!(one, four);
    assert!(one[0] == one[1] && one[2] == one[3] && one[4] == one[5], "{one:?}");
    assert!(one[0] != one[2] && one[2] != one[4], "another seed is another flight: {one:?}");
}

#[test]
fn a_hundred_repeats_have_one_hash() {
    let options = Options { jobs: 4, ..Options::default() };
    let results = run(&short(vec![4], 100), &options, &|_| {}).cases;
    assert_eq!(results.len(), 100);
    assert!(results.iter().all(CaseResult::passed));
}
