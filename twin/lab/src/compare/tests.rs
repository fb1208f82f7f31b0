use super::*;
use nalgebra::Vector3;
use twin_core::fixture;
use twin_core::tick::{Event, EventKind};

/// Ticks of a made flight.
const TICKS: u64 = 900;

/// Ticks by which the second flight begins later.
const LATE: u64 = 170;

/// A flight along a curve that never repeats itself, from tick `first` of the curve on, moved by `aside_m` along y.
fn flown(name: &str, first: u64, aside_m: f64) -> Flown {
    let tick = |index: u64| {
        let at = (first + index) as f64 * 0.01;
        let mut tick = Tick { index, truth: None, events: Vec::new(), ..fixture::tick(index) };
        let position = Vector3::new(at, aside_m + (at * at) / 20.0, 1.0 + 0.1 * at);
        for row in 0..3 {
            tick.measurement.chi[row] = position[row];
        }
        tick.measurement.t_s = (index + 1) as f64 * 0.01;
        if first + index == 400 {
            tick.events.push(Event::new(EventKind::Grasp, "payload gripped"));
        }
        tick
    };
    let ticks = (0..TICKS).map(tick).collect();
    Flown { name: name.to_owned(), recording: Recording { ticks, ..Recording::default() } }
}

/// The offset between the first two flights, ticks.
fn offset(flights: &[Flown], alignment: &Alignment) -> i64 {
    let pair = &compare(flights, alignment).expect("they can be aligned").others[0];
    (pair.offset_s * 100.0).round() as i64
}

#[test]
fn the_best_offset_and_an_event_both_find_how_much_later_a_flight_began() {
    let flights = [flown("a", 0, 0.0), flown("b", LATE, 0.0)];
    let late = LATE.cast_signed();
    assert_eq!(offset(&flights, &Alignment::Start), 0);
    assert_eq!(offset(&flights, &Alignment::Best), late);
    assert_eq!(offset(&flights, &Alignment::Event("gripped".to_owned())), late);
    assert_eq!(offset(&flights, &Alignment::Event("Grasp".to_owned())), late);
    let swapped = [flown("b", LATE, 0.0), flown("a", 0, 0.0)];
    assert_eq!(offset(&swapped, &Alignment::Best), -late);
}

#[test]
fn an_event_that_a_flight_does_not_have_is_refused_with_those_that_it_has() {
    let flights = [flown("a", 0, 0.0), flown("b", 500, 0.0)];
    let error = compare(&flights, &Alignment::Event("gripped".to_owned())).expect_err("b has none");
    assert_eq!(error.to_string(), "b has no event with \"gripped\"; its events are: none");
}

#[test]
fn aligned_flights_are_compared_only_while_both_fly() {
    let flights = [flown("a", 0, 0.0), flown("b", LATE, 0.0)];
    let comparison = compare(&flights, &Alignment::Best).expect("they can be aligned");
    let pair = &comparison.others[0];
    assert!((pair.overlap_s - (TICKS - LATE) as f64 * 0.01).abs() < 1e-9);
    // Both fly the same curve, so at the same instant the heights are equal to rounding.
    let height =
        pair.signals.iter().find(|apart| apart.signal == "height_m").expect("both have it");
    assert!(height.largest.abs() < 1e-12, "{height:?}");
    // Unaligned they are apart by what the curve rises in the delay.
    let pair = &compare(&flights, &Alignment::Start).expect("they can be aligned").others[0];
    let height =
        pair.signals.iter().find(|apart| apart.signal == "height_m").expect("both have it");
    assert!((height.rms - LATE as f64 * 0.001).abs() < 1e-9, "{height:?}");
}

#[test]
fn the_page_names_flights_and_cannot_be_broken_by_their_names() {
    let flights = [flown("a", 0, 0.0), flown("<script>", LATE, 0.0)];
    let comparison = compare(&flights, &Alignment::Best).expect("they can be aligned");
    let page = page(&flights, &comparison);
    assert!(page.contains("&lt;script&gt; beside a") && !page.contains("<script>"));
    assert!(page.contains("height_m: difference") && page.contains("+1.70 s"));
}
