"""Pictures of muscles on their bones, drawn off screen with VTK."""
