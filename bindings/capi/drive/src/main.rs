//! Writes the inputs to standard output, and after each `=` the states of the library in hexadecimal digits.

use scphd_drive::{Event, Filters, Memory, events};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut memory = Box::new(Memory::NEW);
    let mut filters = Filters::new(&mut memory)?;
    for event in events() {
        filters.take(&event)?;
        match event {
            Event::Compare => {
                let digests = filters.digests();
                let states: String = digests.iter().map(|state| format!(" {state:016x}")).collect();
                println!("= {}{states}", digests.len());
            }
            _ => println!("{}", event.line()),
        }
    }
    Ok(())
}
