//! Files that Foxglove fetches: the server gives the vehicle's URDF byte for byte, and refuses files elsewhere.

use super::console::options;
use super::foxglove_client::Foxglove;
use twin_console::server::spawn;

#[test]
fn foxglove_fetches_the_urdf_that_flies_and_no_other_file() {
    let mut options = options();
    options.foxglove_port = Some(0);
    let running = spawn(options).expect("free ports");
    let mut client = Foxglove::connect(running.foxglove_address().expect("a port"));
    let info = client.op("serverInfo");
    assert!(info["capabilities"].as_array().unwrap().contains(&"assets".into()), "{info}");
    let urdf = std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/urdf/aerial_manipulator.urdf"));
    assert_eq!(client.fetch("package://twin/vehicle.urdf", 1), Ok(urdf.expect("it is there")));
    for (id, address) in ["package://twin/../Cargo.toml", "file:///etc/hostname", "Cargo.toml"]
        .into_iter()
        .enumerate()
    {
        let why = client.fetch(address, 2 + id as u32).expect_err(address);
        assert!(why.contains("allowed: package://twin/vehicle.urdf"), "{address}: {why}");
    }
}
