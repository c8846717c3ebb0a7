//! The address space: an object for each board below `Objects`, by the names of the gateway's file.

use std::sync::Arc;

use lang::axis::Axis;
use lang::wire::Control;
use opcua::server::SubscriptionCache;
use opcua::server::address_space::{MethodBuilder, ObjectBuilder, VariableBuilder};
use opcua::server::node_manager::memory::SimpleNodeManager;
use opcua::types::{
    DataTypeId, DataValue, DateTime, NodeId, ObjectTypeId, QualifiedName, StatusCode, Variant,
};

use super::server::Orders;
use crate::client::status::StatusWords;
use crate::gateway::line::Look;
use crate::gateway::named::Named;
use crate::helm::Picture;

/// What every board shows: name and type.
const SHOWN: [(&str, DataTypeId); 14] = [
    ("Online", DataTypeId::Boolean),
    ("State", DataTypeId::String),
    ("Fault", DataTypeId::String),
    ("FaultText", DataTypeId::String),
    ("FaultLine", DataTypeId::UInt16),
    ("LastEnd", DataTypeId::String),
    ("Runs", DataTypeId::UInt16),
    ("PositionX", DataTypeId::Int32),
    ("PositionY", DataTypeId::Int32),
    ("PositionZ", DataTypeId::Int32),
    ("Inputs", DataTypeId::UInt32),
    ("Outputs", DataTypeId::UInt32),
    ("Firmware", DataTypeId::String),
    ("ProgramCrc", DataTypeId::UInt16),
];

/// Methods and what they write.
const METHODS: [(&str, Control); 5] = [
    ("Start", Control::Start),
    ("Stop", Control::Stop),
    ("Pause", Control::Pause),
    ("Resume", Control::Resume),
    ("Acknowledge", Control::Acknowledge),
];

/// See the module.
pub struct Space {
    namespace: u16,
    manager: Arc<SimpleNodeManager>,
    boards: Vec<Shown>,
}

/// A board as it stands in the space.
struct Shown {
    name: String,
    /// Its program's variables that are there: name and unit, which tells the type.
    variables: Vec<(String, &'static str)>,
}

/// Bit n-1 for each number n.
fn bits(numbers: &[u16]) -> u32 {
    numbers.iter().filter(|n| (1..=32).contains(*n)).fold(0, |all, n| all | 1 << (n - 1))
}

fn text(text: Option<&str>) -> Variant {
    Variant::from(text.unwrap_or_default())
}

/// The values of [`SHOWN`] in a picture.
fn values(picture: &Picture) -> Vec<Variant> {
    let status = picture.status.clone().unwrap_or_else(|| StatusWords::default().status());
    let position = |axis: Axis| Variant::from(status.pos.get(axis).unwrap_or(0));
    let identity = picture.identity.as_ref();
    vec![
        true.into(),
        text(Some(status.state)),
        text(status.fault.as_deref()),
        text(status.text),
        status.line.unwrap_or(0).into(),
        text(status.last_end),
        status.runs.into(),
        position(Axis::X),
        position(Axis::Y),
        position(Axis::Z),
        bits(&status.inputs).into(),
        bits(&status.outputs).into(),
        text(identity.map(|identity| identity.firmware.as_str())),
        identity.map_or(0, |identity| identity.program_crc).into(),
    ]
}

impl Space {
    /// Puts all boards there; nothing is known of them yet.
    pub fn new(
        namespace: u16,
        manager: Arc<SimpleNodeManager>,
        names: &[String],
        orders: &Arc<Orders>,
    ) -> Space {
        let shown = |name: &String| Shown { name: name.clone(), variables: Vec::new() };
        let boards = names.iter().map(shown).collect();
        let space = Space { namespace, manager, boards };
        for (board, name) in names.iter().enumerate() {
            space.put_board(board, name, orders);
        }
        space
    }

    fn id(&self, path: &str) -> NodeId {
        NodeId::new(self.namespace, path)
    }

    fn name(&self, name: &str) -> QualifiedName {
        QualifiedName::new(self.namespace, name)
    }

    fn put_board(&self, board: usize, name: &str, orders: &Arc<Orders>) {
        let mut space = self.manager.address_space().write();
        let object = self.id(name);
        ObjectBuilder::new(&object, self.name(name), name)
            .organized_by(NodeId::objects_folder_id())
            .has_type_definition(ObjectTypeId::BaseObjectType)
            .insert(&mut *space);
        for (own, kind) in SHOWN {
            let id = self.id(&format!("{name}/{own}"));
            VariableBuilder::new(&id, self.name(own), own)
                .data_type(kind)
                .value(Variant::Empty)
                .component_of(object.clone())
                .insert(&mut *space);
        }
        let folder = self.id(&format!("{name}/Variables"));
        space.add_folder(&folder, self.name("Variables"), "Variables", &object);
        for (own, control) in METHODS {
            let id = self.id(&format!("{name}/{own}"));
            MethodBuilder::new(&id, self.name(own), own)
                .executable(true)
                .user_executable(true)
                .component_of(object.clone())
                .insert(&mut *space);
            let orders = orders.clone();
            let call = move |_: &[Variant]| orders.control(board, control).map(|()| Vec::new());
            self.manager.inner().add_method_callback(id, call);
        }
    }

    /// Shows what a look brought.
    pub fn show(&mut self, board: usize, look: Look, subscriptions: &SubscriptionCache) {
        let Some(name) = self.boards.get(board).map(|shown| shown.name.clone()) else { return };
        let seen = match look {
            Look::Picture(seen) => seen,
            Look::Silent => return self.show_silence(board, &name, subscriptions),
            Look::Print(_) => return,
        };
        let values = SHOWN.iter().zip(values(&seen.picture));
        let values = values.map(|((own, _), value)| (self.id(&format!("{name}/{own}")), value));
        self.set(values.collect(), None, subscriptions);
        let variables = &seen.variables;
        let now: Vec<_> = variables.iter().map(|named| (named.name.clone(), named.unit)).collect();
        if self.boards[board].variables != now {
            self.put_variables(board, &name, variables);
            self.boards[board].variables = now;
        }
        let value = |named: &Named| match named.real() {
            Some(real) => Variant::from(real),
            None => Variant::from(named.value),
        };
        let values = variables
            .iter()
            .map(|named| (self.id(&format!("{name}/Variables/{}", named.name)), value(named)));
        self.set(values.collect(), None, subscriptions);
    }

    /// A board that does not answer: everything of it is of no use, and it says why.
    fn show_silence(&self, board: usize, name: &str, subscriptions: &SubscriptionCache) {
        let of = |own: &str| (self.id(&format!("{name}/{own}")), Variant::Empty);
        let variables = self.boards[board].variables.iter();
        let variables = variables.map(|(own, _)| of(&format!("Variables/{own}")));
        let values = SHOWN.iter().skip(1).map(|(own, _)| of(own)).chain(variables).collect();
        self.set(values, Some(StatusCode::BadNoCommunication), subscriptions);
        let online = (self.id(&format!("{name}/Online")), false.into());
        self.set(vec![online], None, subscriptions);
    }

    /// Another program has other variables.
    fn put_variables(&self, board: usize, name: &str, variables: &[Named]) {
        let folder = self.id(&format!("{name}/Variables"));
        let mut space = self.manager.address_space().write();
        let of = |own: &str| self.id(&format!("{name}/Variables/{own}"));
        for (own, _) in &self.boards[board].variables {
            space.delete(&of(own), true);
        }
        for named in variables {
            let own = named.name.as_str();
            let what = if named.keep { "KEEP" } else { "AT" };
            let kind = if named.real().is_some() { DataTypeId::Double } else { DataTypeId::Int32 };
            VariableBuilder::new(&of(own), self.name(own), own)
                .data_type(kind)
                .value(Variant::Empty)
                .description(format!("{what} variable {}", named.unit).trim_end())
                .component_of(folder.clone())
                .insert(&mut *space);
        }
    }

    fn set(
        &self,
        values: Vec<(NodeId, Variant)>,
        status: Option<StatusCode>,
        subscriptions: &SubscriptionCache,
    ) {
        let now = DateTime::now();
        let values: Vec<(NodeId, DataValue)> = values
            .into_iter()
            .map(|(id, value)| {
                let mut value = DataValue::new_at(value, now);
                value.status = Some(status.unwrap_or(StatusCode::Good));
                (id, value)
            })
            .collect();
        let each = values.iter().map(|(id, value)| (id, None, value.clone()));
        // A node that is not there any more has nobody who looks at it.
        let _ = self.manager.set_values(subscriptions, each);
    }
}
